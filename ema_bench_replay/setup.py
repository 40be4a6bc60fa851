"""Installs ema_bench_replay where ROS 2 looks for it."""

from setuptools import find_packages, setup

setup(
    name="ema_bench_replay",
    version="0.1.0",
    description="Recordings of an actuator bench: Siemens trace import, MCAP files, replay and record nodes",
    maintainer="EMA twin authors",
    maintainer_email="maintainers@ema-twin.example.org",
    license="Apache-2.0",
    packages=find_packages(),
    package_data={"ema_bench_replay": ["py.typed"], "ema_bench_replay.nodes": ["loopback.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/ema_bench_replay"]),
        ("share/ema_bench_replay", ["package.xml"]),
    ],
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "record = ema_bench_replay.nodes.record:main",
            "replay = ema_bench_replay.nodes.replay:main",
        ]
    },
)
