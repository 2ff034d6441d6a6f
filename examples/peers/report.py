"""The tables and the verdict of a run. A field is a name and its races by scene."""
import datetime
import math
import platform

LEVELS = (1e-3, 1e-6, 1e-9)
SHARES = (50, 90, 99, 100)
# A peer that takes less has as good as nothing to do: no contact touches, or one alone.
SHORT = 0.5e-6


def write(folder, fields, ours, peers):
    import picture  # it needs the numbers of this module

    folder.mkdir(parents=True, exist_ok=True)
    verdict = verdicts(fields, ours[0], peers) if peers else "no external solver was installed."
    verdict += f" ({datetime.date.today()}, one core of {processor()}, `examples/peers`)\n"
    text = f"""# External solvers on the same scenes

{winners(fields, ours[0], peers)}Against the fastest external solver, chosen per scene in hindsight, this crate is {verdict}
Time to an error: the fastest run whose error (`src/guide/error.md`; recomputed in f64) really is at
most that, over two tolerances a decade, least of several turns, cold. Peers get `W` and `q`; the
cost of a call from Python is not in their times. `README.md` says more.
"""
    for name, races in fields:
        file = "profile.svg" if name == "bundled" else f"profile_{name}.svg"
        picture.profile(folder / file, races, ours + peers)
        text += f"""
## {name.capitalize()} scenes: {len(races)}

![Performance profile, {name} scenes]({file})

### Ours in f64 against the fastest peer

"At no iterations" is a solve that is given its own solution, and has only `q`, natural maps, `v` and
the error to compute, of which peers do nothing: about what a method would reach that takes no time.

{comparisons(races, ours[0], peers)}
{slower(races, ours[0], peers)}
### Solvers: time in µs

{solvers(races, ours + peers)}
### Scene by scene, in µs

{each(races, ours[0], peers) if name == "bundled" else classes(races, ours[0], peers)}"""
    (folder / "PEERS.md").write_text(text)
    (folder / "verdict.md").write_text(verdict)
    print(f"written: {folder / 'PEERS.md'}")


def processor():
    try:
        lines = open("/proc/cpuinfo", encoding="utf-8").read().splitlines()
        return next(line.split(": ")[1] for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.machine()


def best(race, name, level):
    """Seconds and work of the fastest run to an error, or None."""
    runs = [(time, work) for error, time, work in race["rungs"][name] if error <= level]
    return min(runs, default=(None, None))


def seconds(race, name, level, prepared=False):
    time = best(race, name, level)[0]
    if time is None or not prepared:
        return time
    return time + race["prepare"].get(name, race["delassus"])


def fastest(race, names, level, prepared=False):
    times = [(seconds(race, name, level, prepared), name) for name in names]
    return min((time for time in times if time[0] is not None), default=(None, "-"))


def mean(values):
    values = list(values)
    return math.exp(sum(map(math.log, values)) / len(values)) if values else math.nan


class Comparison:
    """Our times and the fastest peers', on the scenes that both solve."""

    def __init__(self, races, ours, peers, level, prepared=False):
        self.pairs, self.unsolved = {}, []
        for name, race in races.items():
            own, (peer, _) = seconds(race, ours, level, prepared), fastest(race, peers, level, prepared)
            if own is None:
                self.unsolved.append(name)
            elif peer is not None:
                self.pairs[name] = own, peer
        self.alone = len(races) - len(self.pairs) - len(self.unsolved)

    def ratios(self, least=0.0):
        return {name: peer / own for name, (own, peer) in self.pairs.items() if peer >= least}

    def slower(self, least=0.0):
        return [name for name, ratio in self.ratios(least).items() if ratio < 1.0]


def winners(fields, ours, peers):
    """Who is fastest to which error, on how many scenes of all fields, and where it is not us."""
    if not peers:
        return ""
    races = {(name, scene): race for name, races in fields for scene, race in races.items()}
    first = [{scene: fastest(race, [ours, *peers], level) for scene, race in races.items()} for level in LEVELS]
    counts = {who: [sum(name == who for _, name in found.values()) for found in first] for who in [ours, *peers]}
    each = {who: " / ".join(map(str, count)) for who, count in counts.items()}
    lost = [[found[0] for found in winner.values() if found[1] in peers] for winner in first]
    short = " / ".join(f"{sum(time < SHORT for time in times)} of {len(times)}" for times in lost)
    others = ", ".join(f"{who} on {each[who]}" for who in peers if any(counts[who]))
    return f"""Fastest to 1e-3 / 1e-6 / 1e-9 is {ours} on {each[ours]} of {len(races)} scenes; {others}. Where a peer wins, it mostly takes less than
{SHORT * 1e6} µs ({short}): no contact touches, or one. If that is all that your robot does, or if it is one box that slides and `W` is there
already, a projection a contact is enough, and a loop of your own is faster.

"""


def verdicts(fields, ours, peers):
    """One sentence: geometric means, and on how many scenes we are slower."""
    parts = []
    for name, races in fields:
        for prepared in (False, True):
            found = [Comparison(races, ours, peers, level, prepared) for level in LEVELS]
            each = [
                " / ".join(map(str, values))
                for values in (
                    [f"{mean(c.ratios().values()):.2f}" for c in found],
                    [len(c.slower()) for c in found],
                    [len(c.slower()) - len(c.slower(SHORT)) for c in found],
                )
            ]
            short = "" if prepared else f", {each[2]} of them where the peer takes less than {SHORT * 1e6} µs"
            what = "with preparation" if prepared else f"on {len(races)} {name} scenes"
            parts.append(f"{what} {each[0]} (slower on {each[1]}{short})")
            for level, c in zip(LEVELS, found):
                if c.unsolved:
                    parts.append(f"unsolved to {level:.0e}: {', '.join(c.unsolved)}")
    return f"so many times as fast to 1e-3 / 1e-6 / 1e-9: {'; '.join(parts)}."


def table(header, rows):
    lines = [header, ["---"] + ["---:"] * (len(header) - 1)] + rows
    return "".join("| " + " | ".join(line) + " |\n" for line in lines)


def micro(time):
    return "-" if time is None or math.isnan(time) else f"{time * 1e6:.3g}"


def comparisons(races, ours, peers):
    header = ["to", "times as fast", "at no iterations", "slower on", "worst", "no peer solves"]
    header += [f"peer {SHORT * 1e6} µs or more: times as fast", "slower on", "worst"]
    rows = []
    for prepared in (False, True):
        for level in LEVELS:
            found = Comparison(races, ours, peers, level, prepared)
            row = [f"{level:.0e}{', with preparation' if prepared else ''}"]
            for least in (0.0, SHORT):
                ratios = found.ratios(least)
                row.append(f"{mean(ratios.values()):.2f}")
                if least == 0.0:
                    row.append("-" if prepared else f"{limit(races, peers, level):.2f}")
                row.append(f"{len(found.slower(least))} of {len(ratios)}")
                row.append(f"{min(ratios.values(), default=math.nan):.2f}")
                if least == 0.0:
                    row.append(str(found.alone))
            rows.append(row)
    return table(header, rows)


def limit(races, peers, level):
    """How many times as fast a method would be that takes no time at all."""
    pairs = [(fastest(race, peers, level)[0], race["given"][level]) for race in races.values()]
    return mean(peer / given for peer, given in pairs if peer is not None and given is not None)


def slower(races, ours, peers):
    header = ["slower on", "to", "ours", "work", "at no iterations", "peer", "ratio", "which"]
    rows, short = [], set()
    for level in LEVELS:
        found = Comparison(races, ours, peers, level)
        long = found.slower(SHORT)
        short |= set(found.slower()) - set(long)
        for name in long:
            race, (own, peer) = races[name], found.pairs[name]
            rows.append(
                [name, f"{level:.0e}", micro(own), str(best(race, ours, level)[1]), micro(race["given"][level])]
                + [micro(peer), f"{peer / own:.2f}", fastest(race, peers, level)[1]]
            )
    text = table(header, sorted(rows)) if rows else ""
    if short:
        text += f"\nSlower where the peer takes less than {SHORT * 1e6} µs: {', '.join(sorted(short))}.\n"
    return text


def distribution(times):
    """What a share of the scenes takes at most; None for those unsolved."""
    times = sorted(times, key=lambda time: math.inf if time is None else time)
    return [times[max(math.ceil(len(times) * share / 100), 1) - 1] for share in SHARES]


def solvers(races, names):
    header = ["solver", "to", "solved", "mean, where solved", "median", "90 %", "99 %", "worst"]
    rows = []
    for level in LEVELS:
        for name in names:
            times = [seconds(race, name, level) for race in races.values()]
            solved = [time for time in times if time is not None]
            rows.append([name, f"{level:.0e}", str(len(solved)), micro(mean(solved))])
            rows[-1] += map(micro, distribution(times))
    return table(header, rows)


def each(races, ours, peers):
    """Every scene; the last column is the fastest peer to 1e-6."""
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
    return table(header + ["fastest peer to 1e-06"], rows)


def classes(races, ours, peers):
    """Means of each class, which is in the names before the bracket."""
    header = ["class", "scenes"]
    for level in LEVELS:
        header += [f"ours to {level:.0e}", "peer", "ratio", "slower on"]
    rows = []
    for kind in sorted({name.split("[")[0] for name in races}):
        of = {name: race for name, race in races.items() if name.split("[")[0] == kind}
        row = [kind, str(len(of))]
        for level in LEVELS:
            found = Comparison(of, ours, peers, level)
            row += [micro(mean(times)) for times in zip(*found.pairs.values())]
            row += [f"{mean(found.ratios().values()):.2f}", str(len(found.slower()))]
        rows.append(row)
    return table(header, rows)
