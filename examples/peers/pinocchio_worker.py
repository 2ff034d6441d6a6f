"""Pinocchio's ADMM and PGS on a dense Delassus operator (`pip install pin`)."""
import numpy as np
import pinocchio as pin

from worker import serve

MAX_ITERATIONS = 10_000


def contact_model():
    """Any body will do: the operator is given."""
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "body")
    model.appendBodyToJoint(1, pin.Inertia.Random(), pin.SE3.Identity())
    return model


MODEL = contact_model()


def problem(W, q, mu):
    # Pinocchio's rows are (t1, t2, n).
    order = np.concatenate([[3 * i + 1, 3 * i + 2, 3 * i] for i in range(len(mu))])
    W, q = np.asfortranarray(W[np.ix_(order, order)]), q[order].copy()
    models, datas = pin.StdVec_ConstraintModel(), pin.StdVec_ConstraintData()
    for friction in mu:
        contact = pin.PointContactConstraintModel(MODEL, 0, pin.SE3.Identity(), 1, pin.SE3.Identity())
        contact.setFriction(float(friction))
        models.append(pin.ConstraintModel(contact))
        datas.append(models[-1].createData())

    def prepare(solver, tolerance):
        if solver == "ADMM":
            method, settings, outcome = (
                pin.ADMMConstraintSolver(len(q)),
                pin.ADMMSolverSettings(),
                pin.ADMMSolverResult(),
            )
        else:
            method, settings, outcome = (
                pin.PGSConstraintSolver(),
                pin.PGSSolverSettings(),
                pin.PGSSolverResult(),
            )
        settings.absolute_feasibility_tol = settings.absolute_complementarity_tol = tolerance
        settings.relative_feasibility_tol = settings.relative_complementarity_tol = 0.0
        settings.max_iterations = MAX_ITERATIONS
        settings.measure_timings = True
        # Fresh each time: ADMM leaves its damping inside.
        operator = pin.DelassusOperatorDense(W)
        answer = {}

        def run():
            answer["converged"] = method.solve(operator, q, models, datas, settings, outcome)
            return method.getElapsedTime() * 1e-6  # its own clock, without Python

        def result():
            impulses = np.zeros(len(q))
            impulses[order] = outcome.retrieveConstraintImpulses()
            return answer["converged"], outcome.iterations, impulses

        return run, result

    return prepare


serve(problem)
