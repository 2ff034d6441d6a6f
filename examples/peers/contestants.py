"""Who races: our program `solve` as a process, the libraries as servers. Times in seconds."""
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


class Ours:
    """The default method, timed by the example itself: best of its repeats."""

    ours = True

    def __init__(self, solve, precision):
        self.solve, self.precision = solve, precision
        self.name = f"stiction, {precision}"
        self.path = None

    def open(self, scene):
        self.path = scene.path

    def run(self, tolerance, *arguments):
        command = [self.solve, "--json", "--precision", self.precision, "--budget", "10000"]
        command += ["--tolerance", f"{tolerance:e}", "--repeat", "20", *arguments]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        return json.loads(run.stdout.splitlines()[-1])

    def given(self, tolerance, visits):
        """Least seconds of a solve that starts from its own solution, if it leaves that as it is."""
        scene = json.loads(self.path.read_text())
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump({"n_dof": scene["n_dof"], "dim": scene["dim"], "problems": [scene, scene]}, file)
            file.flush()
            sequence = ("--warm", "--sequence", file.name)
            answers = [self.run(tolerance, *sequence) for _ in range(visits)]
        idle = [a for a in answers if a["iterations"] + a["newton_steps"] == 0]
        return min((answer["solve_ns"] * 1e-9 for answer in idle), default=None)

    def visit(self, tolerance):
        answer = self.run(tolerance, self.path)
        return {
            "seconds": answer["solve_ns"] * 1e-9,
            "prepare": answer["prepare_ns"] * 1e-9,
            "converged": answer["status"] == "Solved",
            "iterations": answer["iterations"] + 10 * answer["newton_steps"],
            "error": answer["error"],
            "v": np.array(answer["v"]),
            "r": np.array(answer["r"]),
        }


class Server:
    """A library in a Python of its own."""

    def __init__(self, python, script):
        self.process = subprocess.Popen(
            [python, HERE / script],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | ONE_THREAD,
        )

    def ask(self, **request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.process.args[1].name} stopped")
        return json.loads(line)


class Peer:
    """One solver of a library, timed without the cost of a call from Python."""

    ours = False

    def __init__(self, server, library, solver):
        self.server, self.solver = server, solver
        self.name = f"{library} {solver}"
        self.scene = None

    def open(self, scene):
        self.scene = scene
        self.server.ask(W=scene.W.tolist(), q=scene.q.tolist(), mu=scene.mu.tolist())

    def visit(self, tolerance):
        answer = self.server.ask(solver=self.solver, tolerance=tolerance)
        r = np.array(answer["r"])
        return answer | {"r": r, "v": self.scene.velocity(r)}


def peers(pinocchio_python, siconos_python):
    """The solvers of those libraries that can be imported."""
    found = []
    for library, python, script, solvers in (
        ("Pinocchio", pinocchio_python, "pinocchio_worker.py", ("ADMM", "PGS")),
        ("Siconos", siconos_python, "siconos_worker.py", ("NSGS", "Newton", "ADMM")),
    ):
        module = "pinocchio" if library == "Pinocchio" else "siconos.numerics"
        test = subprocess.run([python, "-c", f"import {module}"], capture_output=True)
        if test.returncode != 0:
            print(f"{library} cannot be imported by {python}: left out")
            continue
        server = Server(python, script)
        found += [Peer(server, library, solver) for solver in solvers]
    return found
