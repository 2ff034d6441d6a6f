# %% [markdown]
# # From an MJCF to contact forces
#
# A quadruped of 12 kg stands on four feet, is pushed sideways, and slips. MuJoCo has the model, the kinematics, the collision and
# the motors; this package has the contacts. Each `# %%` is a cell for editors that know them; `python from_mjcf.py` runs them all.

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import mujoco
import numpy as np

from stiction import Mode
from stiction.mujoco import Stepper

HERE = Path(__file__).parent if "__file__" in globals() else Path.cwd()
model = mujoco.MjModel.from_xml_path(str(HERE / "models/quadruped.xml"))
data = mujoco.MjData(model)
mujoco.mj_resetDataKeyframe(model, data, 0)

# %% [markdown]
# The stepper takes the place of `mujoco.mj_step`. `tol` is the error up to which a step counts as solved.

# %%
model.opt.timestep = 0.005
stepper = Stepper(model, tol=1e-8)
FEET = ["front_left", "front_right", "hind_left", "hind_right"]
PUSH, LASTS = 65.0, (1.0, 1.15)  # N to the left, s

times, normal, ratio, slips = [], [], [], []
trunk = model.body("trunk").id
while data.time < 2.0:
    data.xfrc_applied[trunk, 1] = PUSH if LASTS[0] <= data.time < LASTS[1] else 0.0
    stepper.step(data)
    force, slip = np.zeros((4, 6)), np.zeros(4, bool)
    for i, contact in enumerate(data.contact):
        if stepper.modes[i] < 0:
            continue
        foot = FEET.index(model.geom(contact.geom[1]).name)
        mujoco.mj_contactForce(model, data, i, force[foot])  # normal first, N
        slip[foot] = stepper.modes[i] == Mode.SLIP
    times.append(data.time)
    normal.append(force[:, 0])
    ratio.append(np.linalg.norm(force[:, 1:3], axis=1) / np.maximum(force[:, 0], 1e-9))
    slips.append(slip)

# %% [markdown]
# Did each step keep the promise? And do the forces carry the robot?

# %%
weight = 9.81 * model.body_subtreemass[0]
standing = np.array(normal)[(np.array(times) > 0.8) & (np.array(times) < 1.0)].sum(axis=1)
print(f"{stepper.steps} steps, {stepper.unsolved} not solved (largest error {stepper.max_error:.0e})")
print(f"feet carry {standing.mean():.4f} N of {weight:.4f} N")
print(f"some foot slips in {np.any(slips, axis=1).sum()} steps, with |f_T| up to {np.max(ratio):.6f} f_N")

# %%
figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(9, 5), layout="constrained")
for axes, rows, label in ((above, normal, "normal force, N"), (below, ratio, "tangential over normal force")):
    axes.plot(times, rows, label=[name.replace("_", " ") for name in FEET])
    axes.axvspan(*LASTS, color="0.9", zorder=0)
    axes.set_ylabel(label)
below.axhline(0.6, color="0.4", linewidth=0.8, linestyle=":")
below.set_xlabel("time, s")
above.legend(ncols=4, frameon=False)
above.set_title(f"A quadruped stands, and is pushed by {PUSH:.0f} N")
(HERE / "target").mkdir(exist_ok=True)
figure.savefig(HERE / "target/from_mjcf.png", dpi=110)
