"""A worked example of the Python interface, in cells.

VS Code, Spyder and Jupyter (with jupytext) open this file as a notebook; ``python docs/examples/notebook.py`` runs it.
"""

# %% [markdown]
# # Which effect does a model lack?
# A virtual bench hides an effect; the stock model is compared with its recordings, and the search is asked.

# %%
from ema_twin_sim import compare, discover, load_model, parse_command, virtual_bench

stock = load_model("polito_bench")
hidden = stock.with_effect("sun_runout", {"torque": 0.03, "phase": 0.7})
commands = ("ramp:0.02", "ramp:0.05", "sine:0.02:0.5")
recordings = [virtual_bench(hidden, parse_command(text), 6.0, seed=k) for k, text in enumerate(commands)]
for recording in recordings:
    print(f"{recording.name}: {len(recording)} samples, {recording.duration:.1f} s, {', '.join(recording.signals)}")

# %% [markdown]
# How far off is the stock model? RMSE beside what the sensors' noise alone would make, in SI units.

# %%
before = compare(recordings, stock)
for name, error in before.overall.items():
    print(f"{name:20s} {error['rmse']:.3g} {error['unit']}, noise {error['noise_floor']:.3g} {error['unit']}")
print(before.where[0].sentence())

# %% [markdown]
# Which effect explains it? The answer is a frozen object; `found.model` has what was found.

# %%
found = discover(recordings, stock)
print(found.verdict, found.added)
for instance, entry in found.parameters.items():
    for parameter, held in entry.items():
        if parameter not in ("effect", "options"):
            print(f"{instance}.{parameter} = {held['value']:.3g} ± {held['std']:.1g} {held['unit']}")

# %% [markdown]
# And what is left? The current is at the noise of its sensor.

# %%
after = compare(recordings, found.model)
print(f"{after.overall['current']['rmse'] / after.overall['current']['noise_floor']:.2f} times the sensor's noise")
