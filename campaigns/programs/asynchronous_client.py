"""Spins in an event loop of asyncio, between sleeps."""

import asyncio

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


async def spinning(node):
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.01)
        await asyncio.sleep(0.01)


async def wrapped(future):
    loop = asyncio.get_running_loop()
    wrapper = loop.create_future()
    future.add_done_callback(lambda done: wrapper.set_result(done.result()))
    return await wrapper


async def run(node):
    client = ActionClient(node, Fibonacci, "fibonacci")
    client.wait_for_server()
    print("send")
    goal = await wrapped(client.send_goal_async(Fibonacci.Goal(order=3)))
    print("accepted", goal.accepted)
    answer = await wrapped(goal.get_result_async())
    print("status", answer.status)
    try:
        await asyncio.wait_for(asyncio.sleep(5), timeout=0.5)
    except asyncio.TimeoutError:
        print("waited")


async def main():
    rclpy.init()
    node = Node("asynchronous")
    spin = asyncio.get_running_loop().create_task(spinning(node))
    await run(node)
    spin.cancel()
    await asyncio.wait([spin])
    rclpy.shutdown()


asyncio.run(main())
