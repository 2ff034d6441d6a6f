"""A box and a quadruped on a slope, for MuJoCo and as scene files."""
import json

import mujoco
import numpy as np

SLOPE, MU, DROP = np.radians(20.0), 0.5, 1e-3
STIFFNESS, DAMPING = 200.0, 10.0  # of a joint, N m/rad and N m s/rad; as in examples/pictures/standing.rs
GRAVITY = 9.81 * np.array([-np.sin(SLOPE), 0.0, -np.cos(SLOPE)])  # the slope is the plane z = 0, uphill is +x

BOX = """<body name="body" pos="0 0 0.05"><freejoint/><geom type="box" size="0.1 0.08 0.05" mass="2"/></body>"""


def leg(x, y):
    side = np.sign(y)
    return f"""
<body pos="{x} {y} 0"><joint axis="1 0 0"/><geom type="sphere" size="0.04" mass="0.6" contype="0" conaffinity="0"/>
  <body pos="0 {0.08 * side} 0" euler="0 45 0"><joint axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="1" contype="0" conaffinity="0"/>
    <body pos="0 0 -0.2" euler="0 -90 0"><joint axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.012" mass="0.2" contype="0" conaffinity="0"/>
      <geom name="foot{x}{y}" type="sphere" pos="0 0 -0.2" size="0.02" mass="0.05"/>
</body></body></body>"""


QUADRUPED = f"""<body name="body" pos="0 0 {0.4 * np.cos(np.pi / 4) + 0.02}"><freejoint/>
<geom type="box" size="0.19 0.05 0.05" mass="8" contype="0" conaffinity="0"/>
{"".join(leg(x, y) for x in (0.2, -0.2) for y in (0.06, -0.06))}</body>"""


def model(body, step, **options):
    """The scene in MuJoCo; its joints are held where they are by motors that bear its weight, and by PD torques."""
    joints = body.count("<joint")
    names = [f"j{k}" for k in range(joints)]
    for name in names:
        body = body.replace("<joint axis", f'<joint name="{name}" axis', 1)
    motors = "".join(
        f'<position joint="{name}" kp="{STIFFNESS}" kv="{DAMPING}"/><motor joint="{name}"/>' for name in names
    )
    words = " ".join(f'{key}="{value}"' for key, value in options.items() if key != "solimp")
    solimp = f'solimp="{options["solimp"]}"' if "solimp" in options else ""
    return mujoco.MjModel.from_xml_string(f"""<mujoco>
<compiler angle="degree"/>
<option timestep="{step}" gravity="{" ".join(map(str, GRAVITY))}" {words}/>
<default><geom friction="{MU} 0.005 0.0001" {solimp}/><joint armature="0.02"/></default>
<worldbody><geom type="plane" size="5 5 1"/>{body}</worldbody><actuator>{motors}</actuator></mujoco>""")


def points(m, d):
    """Where the slope is touched first: corners of the box, or lowest points of the feet."""
    feet = [g for g in range(m.ngeom) if m.geom(g).name.startswith("foot")]
    if feet:
        return [(m.geom_bodyid[g], d.geom_xpos[g] - [0, 0, m.geom_size[g, 0]]) for g in feet]
    x, y, z = m.geom_size[1]
    return [(1, d.xpos[1] + [i * x, j * y, -z]) for i in (1, -1) for j in (1, -1)]


def dynamics(m, d):
    """`M` and `H` (rows of a contact: normal, uphill, across)."""
    mass, rows, jacobian = np.zeros((m.nv, m.nv)), [], np.zeros((3, m.nv))
    mujoco.mj_fullM(m, d, mass)
    for body, point in points(m, d):
        mujoco.mj_jac(m, d, jacobian, None, point, body)
        rows += [jacobian[k].copy() for k in (2, 0, 1)]
    return mass, np.array(rows)


def start(m):
    """A millimetre above the slope, and motors that bear the weight where each foot pulls straight up."""
    d = mujoco.MjData(m)
    mujoco.mj_forward(m, d)
    _, H = dynamics(m, d)
    up = np.array([-GRAVITY[k] for k in (2, 0, 1)])
    lift = np.array([H[3 * k : 3 * k + 3].T @ up for k in range(len(H) // 3)]).T
    share = np.linalg.lstsq(lift[:6], d.qfrc_bias[:6], rcond=None)[0]
    torque = (d.qfrc_bias - lift @ share)[6:]
    d.ctrl[0::2], d.ctrl[1::2] = d.qpos[7:], torque
    d.qpos[2] += DROP
    mujoco.mj_forward(m, d)
    return d


def dump(path, m):
    """A scene file of the first step."""
    d = start(m)
    M, H = dynamics(m, d)
    h, contacts = m.opt.timestep, len(H) // 3
    force = d.qfrc_actuator - d.qfrc_bias
    path.write_text(json.dumps({
        "name": path.stem, "source": f"MuJoCo {mujoco.__version__}", "h": h, "dim": 3, "n_dof": m.nv,
        "n_contacts": contacts, "M": M.tolist(), "H": H.tolist(), "f": (-h * force).tolist(),
        "w": [DROP / h, 0.0, 0.0] * contacts, "mu": [MU] * contacts,
    }))
