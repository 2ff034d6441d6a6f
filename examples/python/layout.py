"""Writes where MuJoCo keeps what the Stepper reads: `rust/mujoco/ffi/layout.rs`, from the headers of the versions that are named.

python layout.py 4.0.0 [3.9.0 …]    (fetches each from the package index; needs gcc)
python layout.py --check            the installed version is in the table, and as its headers say
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

TABLE = Path(__file__).parent / "rust" / "mujoco" / "ffi" / "layout.rs"

FIELDS = {
    "model": """
        nq nv nu nbody njnt ngeom nmocap neq ntendon npair nsensordata
        opt.cone opt.jacobian opt.timestep opt.gravity opt.integrator opt.disableflags opt.ccd_tolerance opt.ccd_iterations
        stat.meansize
        body_parentid body_weldid body_mocapid body_invweight0 body_margin
        jnt_type jnt_dofadr jnt_margin dof_treeid dof_damping dof_invweight0
        geom_type geom_contype geom_conaffinity geom_bodyid geom_dataid geom_rbound geom_aabb geom_margin
        pair_margin hfield_size hfield_nrow hfield_ncol hfield_adr hfield_data site_bodyid
        eq_type eq_obj1id eq_obj2id eq_objtype eq_data tendon_invweight0 tendon_margin
        D_rownnz D_rowadr D_colind signature
    """,
    "data": """
        time ncon nefc qpos qvel ctrl sensordata mocap_pos mocap_quat qacc qDeriv qfrc_smooth qfrc_constraint ten_velocity
        geom_xpos geom_xmat contact efc_type efc_id efc_J efc_pos efc_frictionloss efc_KBIP efc_force signature
    """,
    "contact": "dist pos frame includemargin friction surfacevel dim geom exclude efc_address",
}
STRUCTS = {"model": "mjModel", "data": "mjData", "contact": "mjContact"}


def name(field: str) -> str:
    """Of a field in Rust."""
    return field.replace(".", "_").lower()


def layout(include: Path) -> str:
    """The table of one version, in Rust."""
    lines = ['printf("    Layout {\\n        version: %d,\\n        equality_data: %d,\\n", mjVERSION_HEADER, mjNEQDATA);']
    for part, fields in FIELDS.items():
        struct = STRUCTS[part]
        lines.append(f'printf("        {part}: {part.capitalize()} {{\\n");')
        if part != "data":
            lines.append(f'printf("            size: %zu,\\n", sizeof({struct}));')
        lines += [f'printf("            {name(field)}: %zu,\\n", offsetof({struct}, {field}));' for field in fields.split()]
        lines.append('printf("        },\\n");')
    lines.append('printf("    },\\n");')
    source = f"#include <stdio.h>\n#include <mujoco/mujoco.h>\nint main(void) {{ {' '.join(lines)} return 0; }}\n"
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "layout"
        command = ["gcc", "-x", "c", "-", "-I", str(include), "-o", str(program)]
        subprocess.run(command, input=source, text=True, check=True)
        return subprocess.run([program], check=True, capture_output=True, text=True).stdout


def table(layouts: list[str]) -> str:
    """The whole file."""
    text = "//! Where versions of MuJoCo keep what is read, in bytes. Written by `layout.py`.\n"
    text += "#![allow(clippy::unreadable_literal)]\n\n"
    parts = "".join(f"    pub(super) {part}: {part.capitalize()},\n" for part in FIELDS)
    text += f"pub(super) struct Layout {{\n    pub(super) version: i32,\n    pub(super) equality_data: usize,\n{parts}}}\n\n"
    for part, fields in FIELDS.items():
        rows = "".join(
            f"    pub(super) {name(field)}: usize,\n" for field in [*(["size"] if part != "data" else []), *fields.split()]
        )
        text += f"pub(super) struct {part.capitalize()} {{\n{rows}}}\n\n"
    return text + f"pub(super) static LAYOUTS: &[Layout] = &[\n{''.join(layouts)}];\n"


def fetched(version: str) -> str:
    """The table of a version of the package index."""
    with tempfile.TemporaryDirectory() as folder:
        for package in ("mujoco-core", "mujoco"):  # where the headers are differs by version
            command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, f"{package}=={version}"]
            subprocess.run(command, check=False)
        for wheel in Path(folder).glob("*.whl"):
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(folder, [entry for entry in archive.namelist() if "/include/" in entry])
        return layout(next(Path(folder).glob("*/include")))


def main() -> None:
    """Write the table, or check it."""
    if sys.argv[1:] != ["--check"]:
        TABLE.write_text(table([fetched(version) for version in sys.argv[1:]]))
        return
    import mujoco

    own = layout(Path(mujoco.__file__).parent / "include")
    if re.sub(r"\s|,$", "", own.strip()) not in re.sub(r"\s", "", TABLE.read_text()):
        sys.exit(f"layout.rs does not have MuJoCo {mujoco.__version__} as its headers say; run layout.py")
    print(f"layout of MuJoCo {mujoco.__version__}: as its headers say")


if __name__ == "__main__":
    main()
