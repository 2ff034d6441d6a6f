"""``python -m stiction.view model.xml``: MuJoCo's viewer with contacts that stick (blue) and slip (orange)."""

from __future__ import annotations

import argparse


def main() -> None:
    """Show the model that is named."""
    parser = argparse.ArgumentParser(
        prog="python -m stiction.view", description="Watch a model of MuJoCo: space changes the law, Ctrl and a drag push."
    )
    parser.add_argument("model", help="an MJCF or URDF file")
    parser.add_argument(
        "--for", dest="end", metavar="SECONDS", type=float, default=float("inf"), help="time of the model to stop at"
    )
    given = parser.parse_args()
    try:
        import mujoco

        from ._viewer import watch

        print(watch(mujoco.MjModel.from_xml_path(given.model), given.end))
        return
    except ImportError as error:
        refused = f"{error}; pip install 'stiction[mujoco]'"
    except (RuntimeError, TypeError, ValueError) as error:
        refused = str(error)
    parser.exit(2, f"{parser.prog}: {' '.join(refused.split())}\n")


if __name__ == "__main__":
    main()
