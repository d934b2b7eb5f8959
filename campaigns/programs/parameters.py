"""Has parameters, refuses one value, and acts on another."""

import rclpy
from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter


class Configured(Node):
    def __init__(self):
        super().__init__("configured")
        self.declare_parameter("speed", 0.25)
        self.declare_parameter("name", "waffle")
        self.add_on_set_parameters_callback(self.check)
        self.timer = self.create_timer(self.get_parameter("speed").value, self.tick)
        self.count = 0

    def check(self, parameters):
        for parameter in parameters:
            if parameter.name == "speed" and parameter.value <= 0:
                return SetParametersResult(successful=False, reason="not above zero")
            print("set", parameter.name, parameter.value)
        return SetParametersResult(successful=True)

    def tick(self):
        self.count += 1
        speed = self.get_parameter("speed").value
        if speed != self.timer.timer_period_ns / 1e9:
            self.timer.timer_period_ns = int(speed * 1e9)
            print("period", speed)
        if self.get_parameter("name").value == "done":
            self.set_parameters([Parameter("name", value="over")])
            raise SystemExit


rclpy.init()
rclpy.spin(Configured())
