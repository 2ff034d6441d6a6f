"""The performance profile of a field, told apart without colour."""
from report import LEVELS, best, fastest

LOOKS = [
    ("black", "-", "o"), ("#003ca0", "--", "v"), ("#cd5500", "-", "s"), ("#e08a4f", ":", "^"),
    ("#82397f", "-", "D"), ("#a86fa6", "--", "x"), ("#888888", "-.", "+"),
]


def profile(path, races, names):
    """Share of scenes solved within a factor of the fastest."""
    try:
        import matplotlib
    except ImportError:
        print("matplotlib cannot be imported: no profile drawn")
        return
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "peers"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 3, figsize=(13, 4.2), sharey=True)
    for axis, level in zip(axes, LEVELS):
        first = {scene: fastest(race, names, level)[0] for scene, race in races.items()}
        for name, (color, line, marker) in zip(names, LOOKS):
            times = {scene: best(race, name, level)[0] for scene, race in races.items()}
            ratios = sorted(time / first[scene] for scene, time in times.items() if time is not None)
            if not ratios:
                continue
            share = [100 * (k + 1) / len(races) for k in range(len(ratios))]
            axis.step(
                ratios + [1e3], share + share[-1:], where="post", color=color, linestyle=line,
                marker=marker, markevery=0.1, markersize=5, fillstyle="none", label=name,
            )
        axis.set(xscale="log", xlim=(1, 1e3), ylim=(0, 102), title=f"error at most {level:.0e}")
        axis.set_xlabel("time / time of the fastest on the same scene")
        axis.grid(color="#dddddd")
    axes[0].set_ylabel("scenes solved, %")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.savefig(path, metadata={"Date": None})
