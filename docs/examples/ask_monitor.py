"""Ask the running monitor what the model lacks, add it to the running twin, and watch the error fall.

The nodes `twin` and `monitor` run, beside a bench or a replay; then: `python docs/examples/ask_monitor.py`. It is what
`ros2 service call /monitor/diagnose …` does, for a program of your own.
"""

import rclpy

from ema_bench_replay.nodes import qos
from ema_twin_msgs.msg import EmaState, Health
from ema_twin_msgs.srv import Apply, Diagnose

ENOUGH = 10.0
"""s of comparing before the question; the more there is to judge from, the surer the answer."""

SHOWN = {"current": ("mA", 1), "unexplained_torque": ("mN m", 1), "output_position": ("mrad", 3)}
"""The errors that are printed, of those that the machine has: in thousandths of the message's unit, and decimals."""


def seconds_of(message):
    """The stamp of a sample; of health, that of the last sample that was compared."""
    return message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec


class Client:
    """A node that hears the health and calls the monitor's services."""

    def __init__(self):
        rclpy.init()
        self.node = rclpy.create_node("ask_monitor")
        self.health = Health()
        self.begun = 0.0  # s, of the stamps: when the present run began
        self.node.create_subscription(Health, "/monitor/health", self._keep, qos.LATEST)

    def _keep(self, health):
        if health.run != self.health.run:
            self.begun = seconds_of(health)
        self.health = health

    def wait_for_age(self, seconds):
        """Listen until the present run has lasted so long."""
        while not self.health.compared or seconds_of(self.health) - self.begun < seconds:
            rclpy.spin_once(self.node)

    def wait_for_change(self):
        """Listen for two windows from what the twin answers now: the second holds nothing of before.

        The monitor may be behind the twin, so it is the twin that tells what "now" is. A new run begins a new window.
        """
        answers = []
        listening = self.node.create_subscription(EmaState, "/twin/state", answers.append, qos.STATE_FROM_NOW)
        while not answers:
            rclpy.spin_once(self.node)
        self.node.destroy_subscription(listening)
        run, end = answers[0].run, seconds_of(answers[0]) + 2.0 * self.health.window
        while (self.health.run, seconds_of(self.health)) < (run, end):
            rclpy.spin_once(self.node)

    def call(self, service, name, **request):
        """The answer of a service; ends the program where it refuses."""
        client = self.node.create_client(service, name)
        client.wait_for_service()
        future = client.call_async(service.Request(**request))
        rclpy.spin_until_future_complete(self.node, future)
        answer = future.result()
        if not answer.success:
            raise SystemExit(f"{name}: {answer.message}")
        return answer

    def tell_errors(self, when):
        """Print the errors of the last window.

        A signal that the machine lacks is NaN; a current that drives the twin has no error.
        """
        told = []
        for name, (unit, decimals) in SHOWN.items():
            now, least = (getattr(of, name) * 1e3 for of in (self.health.rmse_window, self.health.noise_floor))
            if now > 0.0:
                told.append(f"{name.replace('_', ' ')} {now:.{decimals}f} {unit} (noise {least:.{decimals}f})")
        print(f"{when}: {', '.join(told) or 'no signal to compare'}", flush=True)


def main():
    """Ask, add, and look."""
    client = Client()
    client.wait_for_age(ENOUGH)
    client.tell_errors("before")
    diagnosis = client.call(Diagnose, "/monitor/diagnose", window=0.0).diagnosis
    print(f"missing: {', '.join(entry.id for entry in diagnosis.ranking if entry.found)}", flush=True)
    print(f"added: {client.call(Apply, '/monitor/apply', effect=[]).message}", flush=True)
    client.wait_for_change()
    client.wait_for_age(2.0 * client.health.window)  # past a run's beginning, where the gap in the gears is unknown
    client.tell_errors("after")
    rclpy.shutdown()


if __name__ == "__main__":
    main()
