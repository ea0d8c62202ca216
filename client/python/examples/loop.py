"""Runs a closed loop in a session: observe, correct, plan, and move, again and again."""

import os

import numpy as np

from bendtwin import Bounds, Client, Keypoints, Search

with Client(os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")) as client:
    twin = next(client.twins())  # the newest
    geometry = twin.geometry()
    from_hand = np.linalg.norm(geometry.rest_positions - geometry.controls.mean(axis=0), axis=1)
    node = int(np.abs(from_hand - 0.1).argmin())  # 10 cm from the hand
    goal = geometry.rest_positions[node] + [0.05, 0.05, 0.15]
    markers = np.arange(0, geometry.surface_count, 3)
    bounds = Bounds(low=[-0.3, -0.3, 0.0], speed=1.0)  # The hand stays above where it was.
    random = np.random.default_rng(0)

    # Slot 0 is what the robot believes; slot 1 stands for the object, which a camera sees.
    with client.open_session(twin, slots=2) as session:
        believed, real = session.states()
        knots = np.repeat(believed.controls[None, None], 4, axis=1)
        for step in range(10):
            seen = real.positions[markers] + random.normal(0.0, 0.001, (len(markers), 3))
            session.correct(seen, nodes=markers, slots=[0])
            plan = session.plan(
                trajectories=knots,
                frames=15,
                costs=[Keypoints(nodes=[node], targets=[goal])],
                space="together",
                search=Search(samples=32, sigma=0.04, bounds=bounds),
                shift_frames=3.0,
            )
            done = plan.knots[:, :2]  # The robot moves to the next knot; both slots follow.
            session.advance(trajectories=np.repeat(done, 2, axis=0), frames=5, slots=[0, 1])
            believed, real = session.states()
            knots = np.concatenate([done[:, 1:], plan.knots[:, 2:], plan.knots[:, -1:]], axis=1)
            away = np.linalg.norm(real.positions[node] - goal)
            print(f"step {step}: {1000 * away:.0f} mm from the goal")
