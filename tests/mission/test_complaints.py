"""Every message a mission can earn: where, what was found, what is allowed."""

import pytest

from crosstrack.errors import InputError
from crosstrack.mission import loads

START = "start: {position: [0, 0, 10]}\n"
ROUTE = "route: [[20, 0, 10]]\n"


def told(text: str) -> list[str]:
    """Return the problems of a mission as text."""
    with pytest.raises(InputError) as caught:
        loads(text)
    return [str(problem) for problem in caught.value.problems]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("speed: 0", "speed: must be greater than 0, found 0"),
        ("speed: '5'", "speed: must be a number, found '5'"),
        ("speed: true", "speed: must be a number, found true"),
        ("speed: yes", "speed: must be a number, found 'yes'"),
        ("speed: .nan", "speed: must be a finite number, found nan"),
        ("speed: .inf", "speed: must be a finite number, found inf"),
        ("speed:", "speed: must be a number, found nothing"),
        ("speed: [5]", "speed: must be a number, found a list of 1"),
        ("sped: 5", "sped: unknown; did you mean 'speed'? known: name, start, route, goal"),
        ("tracker: {kind: carrot, lookahead: -1}", "tracker.lookahead: must be greater than 0, found -1"),
        ("tracker: {kind: carrot, lookahed: 1}", "tracker.lookahed: unknown; did you mean 'lookahead'?"),
        ("tracker: {lookahead: 1}", "tracker: must be {kind: NAME, ...}; known kinds: carrot"),
        ("tracker: carrot", "tracker: must be {kind: NAME, ...}; known kinds: carrot"),
        ("tracker: {kind: carot}", "tracker.kind: unknown tracker 'carot'; did you mean 'carrot'?"),
        ("tracker: {kind: 3}", "tracker.kind: unknown tracker 3; known: carrot"),
        ("vehicle: {kind: quadrotor, airframe: jumbo}", "vehicle.airframe: must be 'generic', 'crazyflie' or 'racer'"),
        ("avoid: [{kind: potentia}]", "avoid[0].kind: unknown avoider 'potentia'; did you mean 'potential'?"),
        ("avoid: {kind: potential}", "avoid: must be a list, found a mapping"),
        ("world: {shapes: [{box: {min: [0, 0, 0], max: [1, 0, 1]}}]}", "world.shapes[0].box: min must be below max"),
        ("world: {shapes: [{cube: {}}]}", "world.shapes[0].cube: unknown; known: box, cylinder, sphere, prism"),
        ("world: {shapes: [{}]}", "world.shapes[0]: exactly one of box, cylinder, sphere or prism is needed"),
        ("world: {shapes: [{sphere: {center: [0, 0], radius: 1}}]}", "center[2]: is missing from the list"),
        ("world: {shapes: [{sphere: {radius: 1}}]}", "world.shapes[0].sphere.center: is required"),
        ("world: {generate: {kind: wood}}", "world.generate.kind: unknown generator 'wood'; known: forest"),
        ("world: {generate: {kind: forest, density: -1}}", "world.generate.density: must be at least 0, found -1"),
        ("world: {bounds: [[0, 0, 0], [0, 1, 1]]}", "world: bounds: the first corner must be below the second"),
        ("world: {bounds: [[0, 0, 0], 1]}", "world.bounds[1]: must be a list, found 1"),
        ("world: {image: {file: no.png}}", "world.image: no.png: no such file: no.png"),
        ("world: {image: {file: a.png, threshold: 300}}", "threshold: must be 'otsu' or at most 255, found 300"),
        ("world: {image: {file: a.png, threshold: x}}", "threshold: must be 'otsu' or a whole number, found 'x'"),
        ("timing: {rate: 0.5}", "timing.rate: must be at least 1, found 0.5"),
        ("limits: {tilt_deg: 90}", "limits.tilt_deg: must be at most 80, found 90"),
        ("wind: {gusts: strong}", "wind.gusts: must be 'none', 'light', 'moderate' or 'severe', found 'strong'"),
        ("frame: nwu", "frame: must be 'enu' or 'ned', found 'nwu'"),
        ("loop: 1", "loop: must be true or false, found 1"),
        ("seed: 1.5", "seed: must be a whole number, found 1.5"),
        ("seed: -1", "seed: must be at least 0, found -1"),
        ("timing: {rate: 1000, timeout: 1e6}", "timing: rate times timeout is 1e+09 steps; at most 5000000"),
        ("name: a/b", "name: must be a plain name"),
        ("name: ''", "name: must be a plain name of 1 to 100 letters"),
        ("name: ..", "name: must be a plain name"),
        ("origin: {latitude: 91}", "origin.latitude: must be at most 90, found 91"),
        ("speed: 1e10", "speed: must be between -1e+09 and 1e+09, found 1e+10"),
        ("speed: 20", "speed: 20 m/s is above limits.speed, 12 m/s"),
    ],
)
def test_one_wrong_line_is_one_problem_with_its_line(line: str, message: str) -> None:
    (problem,) = told(START + ROUTE + line)
    assert problem.startswith("line 3: ")
    assert message in problem


@pytest.mark.parametrize(
    ("route", "messages"),
    [
        ("[]", ["route: must hold at least 1 value, found 0"]),
        ("[1, 2, 3]", [f"route[{k}]: must be a list, found {k + 1}" for k in range(3)]),
        ("[[1]]", ["route[0]: must hold at least 2 values, found 1"]),
        ("[[1, 2, 3, 4]]", ["route[0]: must hold at most 3 values, found 4"]),
        ("[[1, 2, .inf]]", ["route[0][2]: must be a finite number, found inf"]),
        ("[[1, 2, three]]", ["route[0][2]: must be a number, found 'three'"]),
        ("[[1, 2, 3], [4, 5], [6, 7]]", [
            "route[1]: has 2 coordinates, route[0] has 3", "route[2]: has 2 coordinates, route[0] has 3"]),
        ("[[0, 0, 10]]", ["needs at least 2 distinct points, but the start and its points all lie at (0, 0, 10)"]),
        ("[[20, 0, -1]]", ["route[0]: (20, 0, -1) lies 1 m below the ground"]),
        ("missing.plan", ["route: missing.plan: no such file"]),
        ("5", ["route: must be a list, found 5"]),
        ("", ["route: either a route or a goal is needed; neither is given"]),
    ],
)  # fmt: skip
def test_bad_routes(route: str, messages: list[str]) -> None:
    found = told(f"{START}route: {route}\n")
    assert len(found) == len(messages)
    for problem, message in zip(found, messages, strict=True):
        assert message in problem


def test_route_alone_needs_two_points_when_the_start_is_off_it() -> None:
    (problem,) = told("start: {position: [0, 0, 1], on_route: false}\nroute: [[5, 5], [5, 5]]")
    assert "needs at least 2 distinct points, but its points all lie at (5, 5, 1)" in problem


def test_waypoints_outside_the_bounds_or_too_close_are_named_with_their_distance() -> None:
    problems = told(
        "start: {position: [0, 0, 10]}\n"
        "route:\n- [5, 0, 10]\n- [12.5, 0, 10]\n- [5, 5, 10]\n- [5, 5.6, 10]\n"
        "world:\n  bounds: [[-1, -1, 0], [10, 10, 20]]\n"
        "  shapes: [{sphere: {center: [5, 5, 10], radius: 0.5}}]\n"
    )
    assert problems == [
        "line 4: route[1]: (12.5, 0, 10) lies 2.5 m outside world.bounds",
        "line 5: route[2]: (5, 5, 10) lies 0.5 m inside an obstacle; at least vehicle.radius, 0.2 m, is needed",
        "line 6: route[3]: (5, 5.6, 10) lies 0.1 m from an obstacle; at least vehicle.radius, 0.2 m, is needed",
    ]


@pytest.mark.parametrize(
    ("start", "message"),
    [
        ("{position: [0, 0, 0], takeoff: true}", "is on the ground: a takeoff climbs to it, so it must be above"),
        ("{position: [0, 0, -1]}", "(0, 0, -1) lies 1 m below the ground"),
        ("{position: [0, 0, 40]}", "(0, 0, 40) lies 10 m outside world.bounds"),
        ("{position: [5, 5, 10]}", "lies 0.5 m inside an obstacle"),
        ("{position: [5, 5, 15], takeoff: true}", "(5, 5, 0) lies 0.1 m from an obstacle"),
    ],
)
def test_bad_starts(start: str, message: str) -> None:
    world = (
        "world: {bounds: [[-9, -9, -1], [30, 30, 30]], shapes: [{sphere: {center: [5, 5, 10], radius: 0.5}},"
        " {box: {min: [4, 4, 0.1], max: [6, 6, 0.5]}}]}"
    )
    problems = told(f"start: {start}\n{ROUTE}{world}")
    assert any("line 1: start.position: " in problem and message in problem for problem in problems)


def test_every_error_is_reported_at_once_in_the_order_of_the_file() -> None:
    problems = told(
        "speed: 50\n"
        "start: {position: [0, 0, 100]}\n"
        "route: [[20, 0, 10], [20, .nan, 10]]\n"
        "tracker:\n  kind: carrot\n  lookahed: 1\n  heading_gain: -1\n"
        "vehicle: {kind: submarine}\n"
        "world: {bounds: [[-9, -9, 0], [30, 30, 30]]}\n"
        "wind: {mean: [1, 2], gusts: 3}\n"
        "colour: red\n"
    )
    places = [problem.split(": ")[1] for problem in problems]
    assert places == [
        "speed", "route[1][1]", "tracker.lookahed", "tracker.heading_gain", "vehicle.kind",
        "wind.mean[2]", "wind.gusts", "colour",
    ]  # fmt: skip


def test_what_depends_on_a_broken_field_is_not_guessed_at_but_the_rest_is_checked() -> None:
    problems = told(
        START + "route: [[20, 0, 50]]\nlimits: {speed: fast}\nspeed: 50\nworld: {bounds: [[-1, -1, 0], [30, 30, 30]]}"
    )
    assert len(problems) == 2
    assert "route[0]: (20, 0, 50) lies 20 m outside" in problems[0]
    assert "limits.speed: must be a number" in problems[1]


@pytest.mark.parametrize("text", ["", "5", "[1, 2]", "just words"])
def test_a_file_that_is_no_mapping(text: str) -> None:
    assert told(text) == ["must be a mapping of names to values, such as `speed: 5`"]


def test_what_is_required_is_said() -> None:
    assert told("speed: 3") == ["start: is required", "route: either a route or a goal is needed; neither is given"]
    assert told("start: {}\nroute: [[1, 2]]") == ["line 1: start.position: is required"]


def test_the_message_names_the_source_and_the_count() -> None:
    with pytest.raises(InputError, match=r"^mission: 2 problems\n  line 1: speed: .*\n  line 2: seed: "):
        loads("speed: x\nseed: x\n" + START + ROUTE)
