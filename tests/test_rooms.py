"""The rooms of the twin's package: data goes down the list once, and no room knows of one further down."""

from docs.figures.imports import NODES, PACKAGE, arrows, exists, files, imports, place

ROOMS = (
    *("criteria", "version", "parallel", "listing", "text_traces", "quantities", "reading_noise", "interrupts"),
    *("plant", "effects", "model", "own_effects", "simulation", "measured", "identification", "comparison", "fitting"),
    *("discovery/criteria", "discovery/search", "discovery/experiment", "discovery"),
    *("health", "campaign", "new_machine", "words", "live", "nodes", "report", "views", "commands", "entry"),
)
"""From the ground up: each imports from those before it, and from no other."""
FORBIDDEN = {("report", "nodes"), ("views", "nodes"), ("words", "live"), ("campaign", "new_machine")}
"""Arrows that the list allows, and that would still join what has nothing to do with each other."""
ROS = {"rclpy", "rcl_interfaces", "ema_twin_msgs", "diagnostic_msgs", "sensor_msgs", "rosgraph_msgs", NODES}


def room(parts):
    """The room of a module, given by its parts."""
    name = "/".join(parts[:2])
    return name if name in ROOMS else parts[0]


def between_rooms():
    """(room, the other room that it imports from, file) of every import within the package."""
    for file, wanted in arrows():
        if room(wanted) != room(file):
            yield room(file), room(wanted), "/".join(file)


def test_every_folder_and_file_is_in_a_room():
    assert {room(place(file)) for file in files()} - {"__init__"} == set(ROOMS)


def test_what_is_imported_is_there():
    """Within functions too: a type checker takes a module that has moved for a library without types."""
    gone = [(file.name, parts) for file in files() for parts in imports(file) if len(parts) > 1 and not exists(parts)]
    assert gone == []


def test_data_goes_down_the_list():
    up = [(a, b, name) for a, b, name in between_rooms() if ROOMS.index(b) > ROOMS.index(a)]
    assert up == []


def test_report_and_views_know_of_no_command_and_words_of_nobody_who_tells_them():
    assert [arrow for arrow in between_rooms() if arrow[:2] in FORBIDDEN] == []


def test_nothing_imports_in_a_circle():
    """File by file, imports within functions included: what needs the other must not be needed by it."""
    wanted = {module(place(file)): {*map(module, imports(file, typing=False))} for file in files()}
    del wanted[()]  # the package itself: it imports when it is asked for a name
    wanted = {name: needs & wanted.keys() - {name} for name, needs in wanted.items()}
    while free := [name for name, needs in wanted.items() if not needs & wanted.keys()]:
        for name in free:
            del wanted[name]
    assert sorted(wanted) == []


def module(parts):
    """A module by its parts, a folder's own file by those of the folder."""
    return tuple(part for part in parts if part != "__init__")


def test_verbs_import_no_verbs():
    commands = sorted((PACKAGE / "commands").glob("*.py"))
    verbs = {file.stem for file in commands if "EXAMPLES = " in file.read_text()}
    assert len(verbs) >= 20
    for file in commands:
        if file.stem != "main":
            taken = {parts[1] for parts in imports(file) if parts[0] == "commands" and len(parts) > 1}
            assert taken & verbs - {file.stem} == set(), file.name


def test_ros_is_in_the_nodes_alone():
    """The libraries of messages, and the replay's nodes, count as ROS."""
    users = {room(place(file)) for file in files() for parts in imports(file, typing=False) if parts[0] in ROS}
    assert users == {"nodes"}
