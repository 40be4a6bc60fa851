# The other way to use these sources: Ubuntu 24.04 with ROS 2 Jazzy from apt. Written from the documentation and NOT RUN YET;
# the first to build it should correct it, and then this line.
#
#     docker build -f .ci/jazzy.Dockerfile .

FROM ros:jazzy

RUN apt-get update && apt-get install -y --no-install-recommends python3-pip python3-venv && rm -rf /var/lib/apt/lists/*
SHELL ["/bin/bash", "-c"]
WORKDIR /workspace
COPY . .

RUN source /opt/ros/jazzy/setup.bash \
 && apt-get update && rosdep update && rosdep install --from-paths ema_twin_msgs config ema_bench_replay ema_twin_sim \
      --ignore-src -y \
 && python3 -m venv --system-site-packages .venv-ros && touch .venv-ros/COLCON_IGNORE \
 && source .venv-ros/bin/activate && pip install -r requirements.txt \
 && python -m colcon build \
 && source install/setup.bash \
 && ros2 pkg executables ema_bench_replay && ros2 pkg executables ema_twin_sim \
 && ros2 interface show ema_twin_msgs/msg/EmaState \
 && ros2 run ema_twin_sim ema-twin --version
