"""Producer, consumer, a pool and a barrier: threads of Python beside a node."""

import queue
import threading
import time
from concurrent.futures import ThreadPoolExecutor, TimeoutError, as_completed

import rclpy
from rclpy.node import Node


def produce(items):
    for number in range(4):
        time.sleep(0.3)
        items.put(number)
    items.put(None)


def main():
    rclpy.init()
    node = Node("workers")
    ticks = []
    node.create_timer(0.25, lambda: ticks.append(0))
    spinner = threading.Thread(target=rclpy.spin, args=(node,), daemon=True)
    spinner.start()
    print("start")
    items = queue.Queue(maxsize=2)
    threading.Thread(target=produce, args=(items,)).start()
    while (item := items.get()) is not None:
        print("item", item)
    with ThreadPoolExecutor(max_workers=2) as pool:
        jobs = {pool.submit(time.sleep, s): s for s in (0.9, 0.3, 0.3)}
        for job in as_completed(jobs):
            print("slept", jobs[job])
        slow = pool.submit(time.sleep, 1.0)
        try:
            slow.result(timeout=0.4)
        except TimeoutError:
            print("not yet")
    barrier = threading.Barrier(3)
    for _ in range(2):
        threading.Timer(0.4, barrier.wait).start()
    barrier.wait()
    print("together", len(ticks) > 8)
    rclpy.shutdown()
    spinner.join()


main()
