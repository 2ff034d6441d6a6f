"""The table, the performance profile and the verdict of a run."""
import datetime
import math
import platform

LEVELS = (1e-3, 1e-6, 1e-9)
WANTED = 5.0


def write(folder, races, ours, peers):
    folder.mkdir(parents=True, exist_ok=True)
    verdict = verdicts(races, ours[0], peers) if peers else "no external solver was installed."
    text = f"""# External solvers on the same scenes

Against the fastest external solver, chosen per scene in hindsight: {verdict}

Measured {datetime.date.today()}, one core of {processor()}, {len(races)} feasible spatial scenes,
by `examples/peers/peers.py`. Time to an error: the fastest run whose error (README; recomputed in
f64) really is at most that, over two tolerances a decade, least of several turns, cold. Peers get
`W` and `q`; the cost of a call from Python is not in their times.

![Performance profile](profile.svg)

## Solvers

{solvers(races, ours + peers)}
## Scenes

Times in µs; "peer" is the fastest one, named in the last column for 1e-6.

{scenes(races, ours[0], peers)}"""
    (folder / "PEERS.md").write_text(text)
    (folder / "verdict.md").write_text(f"{verdict} ({datetime.date.today()}, `examples/peers`)\n")
    profile(folder / "profile.svg", races, ours + peers)
    print(f"written: {folder / 'PEERS.md'}")


def processor():
    try:
        lines = open("/proc/cpuinfo", encoding="utf-8").read().splitlines()
        return next(line.split(": ")[1] for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()


def seconds(race, name, level, prepared=False):
    """Time to an error, or None."""
    times = [time for error, time, _ in race["rungs"][name] if error <= level]
    if not times:
        return None
    prepare = race["prepare"].get(name, race["delassus"]) if prepared else 0.0
    return min(times) + prepare


def fastest(race, names, level, prepared=False):
    times = [(seconds(race, name, level, prepared), name) for name in names]
    return min((time for time in times if time[0] is not None), default=(None, "-"))


def mean(values):
    return math.exp(sum(map(math.log, values)) / len(values)) if values else math.nan


def verdicts(races, ours, peers):
    """Geometric means and the scenes on which we are slower, at each error, without and with preparation."""
    parts = []
    for level in LEVELS:
        for prepared in (False, True):
            ratios, unsolved = {}, []
            for name, race in races.items():
                peer, _ = fastest(race, peers, level, prepared)
                own = seconds(race, ours, level, prepared)
                if own is None:
                    unsolved.append(name)
                elif peer is not None:
                    ratios[name] = peer / own
            slower = sum(ratio < 1.0 for ratio in ratios.values())
            held = mean(ratios.values()) >= WANTED and not slower and not unsolved
            parts.append(
                f"to {level:.0e} {'with' if prepared else 'without'} preparation "
                f"{mean(ratios.values()):.2f} times as fast, slower on {slower} of {len(ratios)} scenes"
                + (f", unsolved {', '.join(unsolved)}" if unsolved else "")
                + (" (holds)" if held else " (**missed**)")
            )
    wanted = f"wanted {WANTED:.0f} times as fast and slower on no scene; found "
    return f"{wanted}{'; '.join(parts)}. {limits(races, peers)}"


def limits(races, peers):
    """How fast a method would be that takes no time at all."""
    found = []
    for level in LEVELS:
        pairs = [(fastest(race, peers, level)[0], race["given"][level]) for race in races.values()]
        ratios = [peer / given for peer, given in pairs if peer is not None and given is not None]
        slower = sum(ratio < 1.0 for ratio in ratios)
        found.append(
            f"{mean(ratios):.1f} times as fast to {level:.0e} (slower on {slower}, "
            f"below {WANTED:.0f} on {sum(ratio < WANTED for ratio in ratios)} of {len(ratios)})"
        )
    return (
        "A solve without preparation that is given its own solution, and has only `q`, natural maps, "
        "`v` and the error to compute, of which peers do nothing, is " + ", ".join(found)
        + ": about what a method would reach that takes no time."
    )


def table(header, rows):
    lines = [header, ["---"] + ["---:"] * (len(header) - 1)] + rows
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def micro(time):
    return "-" if time is None else f"{time * 1e6:.3g}"


def solvers(races, names):
    header = ["solver"] + [f"solved to {level:.0e}" for level in LEVELS]
    header += [f"µs to {level:.0e}, where solved" for level in LEVELS]
    rows = []
    for name in names:
        times = [[seconds(race, name, level) for race in races.values()] for level in LEVELS]
        solved = [[time for time in level if time is not None] for level in times]
        rows.append(
            [name]
            + [str(len(level)) for level in solved]
            + [micro(mean(level)) if level else "-" for level in solved]
        )
    return table(header, rows)


def scenes(races, ours, peers):
    header = ["scene", "prepare", "`W`"]
    for level in LEVELS:
        header += [f"ours to {level:.0e}", "peer", "ratio"]
    rows = []
    for name, race in races.items():
        row = [name, micro(race["prepare"].get(ours)), micro(race["delassus"])]
        for level in LEVELS:
            own, (peer, _) = seconds(race, ours, level), fastest(race, peers, level)
            both = own is not None and peer is not None
            row += [micro(own), micro(peer), f"{peer / own:.2f}" if both else "-"]
        rows.append(row + [fastest(race, peers, LEVELS[1])[1]])
    return table(header + ["fastest peer"], rows)


def profile(path, races, names):
    """Share of scenes solved within a factor of the fastest, told apart without colour."""
    try:
        import matplotlib
    except ImportError:
        print("matplotlib cannot be imported: no profile drawn")
        return
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "peers"
    from matplotlib import pyplot

    looks = [
        ("black", "-", "o"), ("#003ca0", "--", "v"), ("#cd5500", "-", "s"), ("#e08a4f", ":", "^"),
        ("#82397f", "-", "D"), ("#a86fa6", "--", "x"), ("#888888", "-.", "+"),
    ]
    figure, axes = pyplot.subplots(1, 3, figsize=(13, 4.2), sharey=True)
    for axis, level in zip(axes, LEVELS):
        best = {scene: fastest(race, names, level)[0] for scene, race in races.items()}
        for name, (color, line, marker) in zip(names, looks):
            times = {scene: seconds(race, name, level) for scene, race in races.items()}
            ratios = sorted(time / best[scene] for scene, time in times.items() if time is not None)
            if not ratios:
                continue
            share = [100 * (k + 1) / len(races) for k in range(len(ratios))]
            axis.step(
                ratios + [1e3], share + share[-1:], where="post", color=color, linestyle=line,
                marker=marker, markevery=5, markersize=5, fillstyle="none", label=name,
            )
        axis.set(xscale="log", xlim=(1, 1e3), ylim=(0, 102), title=f"error at most {level:.0e}")
        axis.set_xlabel("time / time of the fastest on the same scene")
        axis.grid(color="#dddddd")
    axes[0].set_ylabel("scenes solved, %")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), fontsize=9, frameon=False)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.savefig(path, metadata={"Date": None})
