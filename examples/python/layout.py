"""Writes where MuJoCo keeps what the Stepper reads: `rust/mujoco/ffi/layout.rs`, from the headers of the versions that are named.

python layout.py 3.3.0 … 4.0.0    (fetches each from the package index; needs gcc and rustfmt)
python layout.py --check          the installed version is in the table, and as its headers say

Types of fields and functions are checked by the compiler. A version that has others is refused.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

TABLE = Path(__file__).parent / "rust" / "mujoco" / "ffi" / "layout.rs"

# Fields by their type. What ends in ? is not in all versions.
FIELDS = {
    "model": {
        "int": "opt.cone opt.jacobian opt.integrator opt.disableflags opt.enableflags opt.ccd_iterations",
        "mjtNum": "opt.timestep opt.ccd_tolerance stat.meansize",
        "mjtNum[3]": "opt.gravity",
        "int*": """
            body_parentid body_weldid body_mocapid jnt_type jnt_dofadr dof_treeid
            geom_type geom_contype geom_conaffinity geom_bodyid geom_dataid hfield_nrow hfield_ncol hfield_adr
            site_bodyid eq_type eq_obj1id eq_obj2id eq_objtype actuator_trntype D_rownnz? D_rowadr? D_colind?
        """,
        "mjtNum*": """
            body_invweight0 body_margin jnt_margin dof_damping dof_invweight0 geom_rbound geom_aabb geom_margin
            pair_margin hfield_size eq_data eq_solref tendon_invweight0 tendon_margin
        """,
        "float*": "hfield_data",
        "uint64_t": "signature?",
        "mjtSize": "nactuator?",
    },
    "data": {
        "int": "ncon nefc",
        "mjtNum": "time",
        "void*": "buffer",
        "size_t|int64_t": "nbuffer",
        "mjtNum*": """
            qpos qvel ctrl sensordata mocap_pos mocap_quat qacc qDeriv qfrc_smooth qfrc_constraint ten_velocity
            geom_xpos geom_xmat qM? efc_J efc_pos efc_frictionloss efc_KBIP efc_force
        """,
        "int*": "efc_type efc_id D_rownnz? D_rowadr? D_colind?",
        "mjContact*": "contact",
        "uint64_t": "signature?",
        "unsigned char|_Bool": "flg_rnepost?",
    },
    "contact": {
        "mjtNum": "dist includemargin",
        "mjtNum[2]": "solref",
        "mjtNum[3]": "pos surfacevel?",
        "mjtNum[9]": "frame",
        "mjtNum[5]": "friction",
        "int": "dim exclude efc_address",
        "int[2]": "geom",
    },
}
SIZES = "nq nv nu nbody njnt ngeom nmocap neq ntendon npair nsensordata"  # of a model: `int` or `mjtSize`
STRUCTS = {"model": "mjModel", "data": "mjData", "contact": "mjContact"}

# Numbers of a version: the first of these expressions that its headers know.
NUMBERS = {
    "equality_data": ("mjNEQDATA",),
    "size_bytes": ("sizeof(((mjModel*)0)->nq)",),
    "damper_off": ("mjDSBL_DAMPER", "mjDSBL_PASSIVE"),
    "euler_damping_off": ("mjDSBL_EULERDAMP",),
    "islands_off": ("mjDSBL_ISLAND", "0"),
    "islands_on": ("mjENBL_ISLAND", "0"),
}

# Numbers that are the same in all versions.
CONSTANTS = {
    **{"EULER": "mjINT_EULER", "IMPLICITFAST": "mjINT_IMPLICITFAST", "ELLIPTIC": "mjCONE_ELLIPTIC", "DENSE": "mjJAC_DENSE"},
    **{"PLANE": "mjGEOM_PLANE", "HFIELD": "mjGEOM_HFIELD", "BOX": "mjGEOM_BOX", "MESH": "mjGEOM_MESH"},
    **{"FREE": "mjJNT_FREE", "BALL": "mjJNT_BALL", "SLIDE": "mjJNT_SLIDE"},
    **{"CONNECT": "mjEQ_CONNECT", "WELD": "mjEQ_WELD", "SITE": "mjOBJ_SITE"},
    "BODY": "mjTRN_BODY",
}

# Types of functions, as `ffi` calls them. (`unsigned` and `int` are passed alike; `mjd_smooth_vel` is in no header.)
FUNCTIONS = {
    "void (*)(const mjModel*, mjData*)": """
        mj_step1 mj_fwdActuation mj_fwdAcceleration mj_kinematics mj_comPos mj_collision mj_makeConstraint mj_checkAcc mj_sensorAcc
        mj_Euler mj_resetData mj_transmission
    """,
    "void (*)(const mjModel*, const mjData*, mjtNum*)|void (*)(const mjModel*, mjtNum*, const mjtNum*)": "mj_fullM",
    "void (*)(const mjModel*, const mjData*, mjtNum*, mjtNum*, const mjtNum*, int)": "mj_jac",
    "int (*)(const mjModel*, mjData*, const mjContact*)": "mj_addContact",
    "void (*)(const mjModel*, mjtNum*, mjtNum, const mjtNum*, const mjtNum*)": "mj_differentiatePos",
    "void (*)(const mjModel*, mjtNum*, const mjtNum*, mjtNum)": "mj_integratePos",
    "mjData* (*)(const mjModel*)": "mj_makeData",
    "mjData* (*)(mjData*, const mjModel*, const mjData*)": "mj_copyData",
    "void (*)(mjData*)": "mj_deleteData",
    **{
        f"void (*)({arguments}, int)|void (*)({arguments}, unsigned)": function
        for arguments, function in (
            ("const mjModel*, mjData*, const mjtNum*", "mj_setState"),
            ("const mjModel*, const mjData*, mjtNum*", "mj_getState"),
        )
    },
}


def name(field: str) -> str:
    """Of a field in Rust."""
    return field.rstrip("?").replace(".", "_").lower()


def fields(part: str) -> list[str]:
    """What the table has of a struct, in its order."""
    first = {"model": ["size", *SIZES.split()], "data": [], "contact": ["size"]}[part]
    return [*first, *(field for some in FIELDS[part].values() for field in some.split())]


class Headers:
    """The headers of a version."""

    def __init__(self, include: Path) -> None:
        """Take the folder of the headers."""
        self.gcc = ["gcc", "-x", "c", "-", "-I", str(include)]

    def compiles(self, line: str) -> bool:
        """Do the headers know what this line needs?"""
        source = f"#include <mujoco/mujoco.h>\nvoid own(void) {{ (void)({line}); }}\n"
        return not subprocess.run(
            [*self.gcc, "-fsyntax-only"], input=source, text=True, capture_output=True, check=False
        ).returncode

    def told(self, lines: list[str]) -> list[str]:
        """What a program of these lines prints."""
        source = (
            "#include <stdio.h>\n#include <stddef.h>\n#include <mujoco/mujoco.h>\nint main(void) {\n" + "\n".join(lines) + "\n}\n"
        )
        with tempfile.TemporaryDirectory() as folder:
            program = Path(folder) / "layout"
            subprocess.run([*self.gcc, "-o", str(program)], input=source, text=True, check=True)
            return subprocess.run([program], check=True, capture_output=True, text=True).stdout.split()


def layout(include: Path) -> tuple[str, str, list[str]]:
    """Of one version: its number, its layout in Rust, and the numbers that all have."""
    headers = Headers(include)
    lines = ['_Static_assert(sizeof(mjtNum) == 8, "double");']
    for types, functions in FUNCTIONS.items():
        for function in functions.split():
            known = ", ".join(f"{kind}: 1" for kind in types.split("|"))
            lines.append(f'_Static_assert(_Generic({function}, {known}, default: 0), "{function}");')
    lines += ['printf("%d ", mjVERSION_HEADER);', *(f'printf("%d ", (int){constant});' for constant in CONSTANTS.values())]
    for choices in NUMBERS.values():
        lines.append(f'printf("%d ", (int){next(choice for choice in choices if headers.compiles(choice))});')
    lines.append('printf("%d ", (int)_Generic(mj_fullM, void (*)(const mjModel*, const mjData*, mjtNum*): 1, default: 0));')
    for part, kinds in FIELDS.items():
        struct = STRUCTS[part]
        if part != "data":
            lines.append(f'printf("%zu ", sizeof({struct}));')
        if part == "model":
            lines += [f'printf("%zu ", offsetof({struct}, {field}));' for field in SIZES.split()]
        for kind, some in kinds.items():
            for field in some.split():
                bare = field.rstrip("?")
                own = f"(({struct}*)0)->{bare}"
                if field.endswith("?") and not headers.compiles(f"&{own}"):
                    lines.append('printf("NONE ");')
                    continue
                known = ", ".join(f"__typeof__({one})*: 1" for one in kind.split("|"))
                lines.append(f'_Static_assert(_Generic(&{own}, {known}, default: 0), "{field}");')
                lines.append(f'printf("%zu ", offsetof({struct}, {bare}));')
    told = headers.told(lines)
    version, constants, told = told[0], told[1 : 1 + len(CONSTANTS)], told[1 + len(CONSTANTS) :]
    text = "".join(f"{number}: {told.pop(0)}, " for number in NUMBERS)
    text += f"mass_of_data: {('false', 'true')[int(told.pop(0))]}, "
    for part in FIELDS:
        count = len(fields(part))
        text += f"{part}: {part.capitalize()}::new([{', '.join(told[:count])}]), "
        del told[:count]
    return version, text, constants


def table(layouts: list[tuple[str, str, list[str]]]) -> str:
    """The whole file. Versions with the same layout share an entry."""
    (constants,) = {tuple(own) for _, _, own in layouts}
    text = "//! Where versions of MuJoCo keep what is read, in bytes. Written by `layout.py`.\n"
    text += "#![allow(clippy::unreadable_literal)]\n\n"
    text += "".join(f"pub(in super::super) const {own}: i32 = {value};\n" for own, value in zip(CONSTANTS, constants, strict=True))
    text += "\n/// What a version does not have.\nconst NONE: usize = usize::MAX;\n\n"
    text += "const fn some(offset: usize) -> Option<usize> { if offset == NONE { None } else { Some(offset) } }\n\n"
    kinds = {"equality_data": "usize", "size_bytes": "usize"}
    text += "pub(super) struct Layout {\n    pub(super) versions: &'static [i32],\n"
    text += "".join(f"    pub(super) {number}: {kinds.get(number, 'i32')},\n" for number in NUMBERS)
    text += "    /// `mj_fullM` takes the data, and not its matrix.\n    pub(super) mass_of_data: bool,\n"
    text += "".join(f"    pub(super) {part}: {part.capitalize()},\n" for part in FIELDS) + "}\n\n"
    for part in FIELDS:
        own, title = fields(part), part.capitalize()
        kinds = {field: "Option<usize>" if field.endswith("?") else "usize" for field in own}
        text += f"pub(super) struct {title} {{\n"
        text += "".join(f"    pub(super) {name(field)}: {kind},\n" for field, kind in kinds.items()) + "}\n\n"
        names = ", ".join(name(field) for field in own)
        made = ", ".join(f"{name(field)}: some({name(field)})" if field.endswith("?") else name(field) for field in own)
        text += f"impl {title} {{ const fn new([{names}]: [usize; {len(own)}]) -> Self {{ Self {{ {made} }} }} }}\n\n"
    shared: dict[str, list[str]] = {}
    for version, own, _ in layouts:
        shared.setdefault(own, []).append(version)
    entries = "".join(f"Layout {{ versions: &[{', '.join(versions)}], {own} }}, " for own, versions in shared.items())
    return text + f"pub(super) static LAYOUTS: &[Layout] = &[{entries}];\n"


def fetched(version: str) -> tuple[str, str, list[str]]:
    """The layout of a version of the package index."""
    with tempfile.TemporaryDirectory() as folder:
        for package in ("mujoco-core", "mujoco"):  # where the headers are differs by version
            command = [sys.executable, "-m", "pip", "download", "-q", "--no-deps", "-d", folder, f"{package}=={version}"]
            subprocess.run(command, check=False, stderr=subprocess.DEVNULL)
        for wheel in Path(folder).glob("*.whl"):
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(folder, [entry for entry in archive.namelist() if "/include/" in entry])
        return layout(next(Path(folder).glob("*/include")))


def main() -> None:
    """Write the table, or check it."""
    if sys.argv[1:] != ["--check"]:
        TABLE.write_text(table([fetched(version) for version in sys.argv[1:]]))
        subprocess.run(["rustfmt", "--edition", "2024", str(TABLE)], check=True)
        return
    import mujoco

    version, own, _ = layout(Path(mujoco.__file__).parent / "include")
    bare, own = (re.sub(r"\s|,(?=\s*[\]}])", "", text) for text in (TABLE.read_text(), own.strip(", ")))
    if not re.search(rf"versions:&\[[\d,]*\b{version}\b[\d,]*\],{re.escape(own)}", bare):
        sys.exit(f"layout.rs does not have MuJoCo {mujoco.__version__} as its headers say; run layout.py")
    print(f"layout of MuJoCo {mujoco.__version__}: as its headers say")


if __name__ == "__main__":
    main()
