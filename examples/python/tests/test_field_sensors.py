"""Sensors read this step: each kind beside ``mj_step`` on an arm that swings; statics and Newton's law where contacts carry."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import mujoco
import numpy as np
import pytest
import test_patch
from field import FLOOR, Array, G, Scene, box, scene

from stiction.mujoco import Stepper, patch, rollout

SENSOR = mujoco.mjtSensor
# Each kind by its element, with what it is of. Versions lack some.
KINDS = {
    **dict.fromkeys(
        ["accelerometer", "velocimeter", "gyro", "force", "torque", "magnetometer", "rangefinder", "touch"], 'site="s"'
    ),
    **dict.fromkeys(["jointpos", "jointvel", "jointactuatorfrc", "jointlimitpos", "jointlimitvel", "jointlimitfrc"], 'joint="a"'),
    **dict.fromkeys(
        ["tendonpos", "tendonvel", "tendonactuatorfrc", "tendonlimitpos", "tendonlimitvel", "tendonlimitfrc"], 'tendon="t"'
    ),
    **dict.fromkeys(["actuatorpos", "actuatorvel", "actuatorfrc"], 'actuator="m"'),
    **dict.fromkeys(["ballquat", "ballangvel"], 'joint="b"'),
    **dict.fromkeys(["framepos", "framequat", "framexaxis", "frameyaxis", "framezaxis"], 'objtype="site" objname="s"'),
    **dict.fromkeys(["framelinvel", "frameangvel", "framelinacc", "frameangacc"], 'objtype="body" objname="B"'),
    **dict.fromkeys(["subtreecom", "subtreelinvel", "subtreeangmom"], 'body="A"'),
    **dict.fromkeys(["distance", "normal", "fromto"], 'body1="A" body2="C" cutoff="9"'),
    **dict.fromkeys(["clock", "e_potential", "e_kinetic"], ""),
    "camprojection": 'site="s" camera="c"',
    "insidesite": 'objtype="body" objname="B" site="s"',
    "contact": 'subtree1="A"',
    "user": 'dim="6" needstage="acc"',
}
# Those of a mesh, and of plugins.
OTHERS = {int(getattr(SENSOR, name, -1)) for name in ("mjSENS_TACTILE", "mjSENS_PLUGIN")}
ARM = """<mujoco><option timestep=".002" magnetic="0 .2 .3"/><worldbody><site name="o"/>
    <camera name="c" pos="0 -2 1" xyaxes="1 0 0 0 0 1" resolution="64 48"/>
    <body name="C" pos="0 2 1"><geom size=".1" contype="0" conaffinity="0"/></body><body name="A" pos="0 0 1">
    <joint name="a" axis="0 1 0" range="-900 900" limited="true"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".3"/>
    <body name="B" pos=".3 0 0"><joint name="b" type="ball"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02" mass=".2"/>
    <site name="s" pos=".2 0 0" size=".06"/></body></body></worldbody>
    <tendon><spatial name="t" stiffness="1" range="0 9" limited="true"><site site="o"/><site site="s"/></spatial></tendon>
    <actuator><motor name="m" joint="a"/><motor tendon="t"/></actuator><sensor>{}</sensor></mujoco>"""


def builds(line: str) -> bool:
    """Does this version of MuJoCo have the sensor?"""
    try:
        mujoco.MjModel.from_xml_string(ARM.format(line))
    except ValueError:
        return False
    return True


SENSORS = [line for line in (f"<{kind} {of}/>" for kind, of in KINDS.items()) if builds(line)]
XML = ARM.format("".join(SENSORS))


STEPS = 300
CONTROLS = np.stack([0.5 * np.sin(0.05 * np.arange(STEPS)), np.full(STEPS, 0.1)], axis=1)  # N·m, N


def readings(data: mujoco.MjData, step: Callable[[Array], None]) -> Array:
    """What sensors read in each step, ``(steps, nsensordata)``; among them a user's sensor that reads the force on a body."""
    model, read = data.model, []
    at = model.sensor_adr[model.sensor_type == SENSOR.mjSENS_USER][0]

    def sensor(_model: int, _data: int, stage: int) -> None:
        if stage == mujoco.mjtStage.mjSTAGE_ACC:
            data.sensordata[at : at + 6] = data.cfrc_int[-1]

    mujoco.set_mjcb_sensor(ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int)(sensor))
    try:
        for control in CONTROLS:
            step(control)
            read.append(data.sensordata.copy())
    finally:
        mujoco.set_mjcb_sensor(None)
    return np.array(read)


def truth(model: mujoco.MjModel) -> Array:
    data = mujoco.MjData(model)

    def step(control: Array) -> None:
        data.ctrl[:] = control
        mujoco.mj_step(model, data)

    return readings(data, step)


def by_step(model: mujoco.MjModel) -> Array:
    data, stepper = mujoco.MjData(model), Stepper(model)

    def step(control: Array) -> None:
        data.ctrl[:] = control
        stepper.step(data)

    return readings(data, step)


def by_halves(model: mujoco.MjModel) -> Array:
    data, stepper = mujoco.MjData(model), Stepper(model)

    def step(control: Array) -> None:
        stepper.step1(data)
        data.ctrl[:] = control
        stepper.step2(data)

    return readings(data, step)


def by_patch(_: mujoco.MjModel) -> Array:
    env = test_patch.Robosuite()
    patch(env)
    data = env.sim.data._data

    def step(control: Array) -> None:
        data.ctrl[:] = control
        env.sim.step()

    return readings(data, step)


def by_rollout(model: mujoco.MjModel) -> Array:
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros(mujoco.mj_stateSize(model, kind))
    mujoco.mj_getState(model, mujoco.MjData(model), start, kind)
    read: Array = rollout(model, start[None], CONTROLS[None]).sensors[0]
    return read


def test_every_kind_of_sensor_is_tried() -> None:
    kinds = set(mujoco.MjModel.from_xml_string(XML).sensor_type) | OTHERS
    assert kinds >= {int(getattr(SENSOR, name)) for name in dir(SENSOR) if name.startswith("mjSENS_")}


@pytest.mark.parametrize("way", [by_step, by_halves, by_rollout, by_patch])
def test_sensors_without_contacts_are_those_of_mj_step(
    way: Callable[[mujoco.MjModel], Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(test_patch, "XML", XML)
    model = mujoco.MjModel.from_xml_string(XML)
    known, read = truth(model), way(model)
    if way is by_rollout:  # nobody is asked there
        known[:, model.sensor_adr[model.sensor_type == SENSOR.mjSENS_USER][0] :][:, :6] = 0.0
    assert np.allclose(read, known, rtol=1e-6, atol=1e-6)
    at = model.sensor_adr[model.sensor_type == SENSOR.mjSENS_ACCELEROMETER][0]
    assert np.ptp(known[:, at : at + 3], axis=0).max() > 1.0


def lifted(h: float) -> Scene:
    """A box of 2 kg with one of 1 kg on a stopped hinge, and a site between."""
    above = '<body pos="0 0 .2"><joint type="hinge" axis="1 0 0" range="0 .001" limited="true"/><site name="s" pos="0 0 -.1"/>'
    above += '<geom type="box" size=".05 .05 .05" mass="1"/></body></body>'
    below = box(".1 .1 .1", "0 0 .1", 2.0).replace("</body>", above)
    sensors = '<force site="s"/><accelerometer site="s"/><framelinacc objtype="site" objname="s"/>'
    return scene(FLOOR + below, f"<sensor>{sensors}</sensor>", h=h)


@pytest.mark.parametrize("h", [0.001, 0.005])
def test_a_force_sensor_reads_the_weight_above_and_what_lifts_it(h: float) -> None:
    s = lifted(h)

    def reads(force: float, felt: float) -> bool:
        return bool(np.allclose(s.data.sensordata[2::3], [force, felt, felt], atol=1e-6))

    s.data.qpos[2] = 1.1
    s.run(0.05)
    assert reads(0.0, 0.0)  # falls
    s.run(1.0)
    assert reads(G, G)  # stands
    s.data.xfrc_applied[2, 2] = 5.0
    s.run(0.1)
    assert reads(G - 5.0, G)  # the upper box is lifted by 5 N
    s.data.xfrc_applied[:, 2] = 0.0, 50.0, 0.0
    s.run(0.1)
    assert reads(50 / 3, 50 / 3)  # both fly
    assert s.is_clean()


def test_forces_on_bodies_are_those_that_act() -> None:
    """``cfrc_ext`` and ``cfrc_int`` of a box that is pushed: what its contacts bear, about its centre of mass."""
    s = scene(FLOOR + box(".1 .1 .1", "0 0 .1", 2.0) + '<body><site name="w"/></body>', '<sensor><force site="w"/></sensor>')
    s.data.xfrc_applied[1, :3] = 3.0, 0.0, -4.0
    s.run(0.5)
    # What the floor bears, and the push: together they hold the weight.
    assert s.data.cfrc_ext[1, 3:] == pytest.approx([0.0, 0.0, 2 * G], abs=1e-6)
    assert s.data.cacc[1, 3:] == pytest.approx([0.0, 0.0, G], abs=1e-6) and s.is_clean()
