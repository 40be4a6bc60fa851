"""Benches for the tests of fits, and how their results are read."""

from tests.recorded import record

SLOW = ("ramp:0.03", "sine:0.05:0.25", "triangle:0.04:2")
FAST = ("ramp:0.2", "sine:0.3:0.25", "triangle:0.1:1")


def bench(model, commands, seconds=6.0, seed=0):
    return record(model, commands, seconds, 100 * seed)


def with_effects(model, effects, typical=False):
    for id, parameters in effects.items():
        model = model.with_effect(id, {} if typical else parameters)
    return model


def estimates(result):
    """(path, value, standard error) of every number that was fitted."""
    for name, entry in result.parameters.items():
        for parameter, held in entry.items():
            if parameter not in ("effect", "options") and held["std"] is not None:
                yield f"effects.{name}.{parameter}", held["value"], held["std"]
    for part, entries in result.constants.items():
        for name, held in entries.items():
            yield f"{part}.{name}", held["value"], held["std"]


def true_value(model, path):
    if path.startswith("effects."):
        _, name, parameter = path.split(".")
        return model.effects[name].parameters[parameter]
    return model.value(path)


def check_recovered(result, true, share=0.05):
    for path, value, std in estimates(result):
        right = true_value(true, path)
        assert abs(value - right) < 3.5 * std, (path, value, std, right)
        assert abs(value - right) < share * max(abs(right), 0.1), (path, value, right)


def warned(result, kind):
    return {(w.instance, w.parameter) for w in result.warnings if w.kind == kind}
