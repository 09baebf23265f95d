"""table.csv for programs and table.md for people: one row per point of a run."""
import pandas

from results import BASELINES, PLACE_COLUMNS, paretoFront

STANDARD = ("uniform", "2048")  # the shadow map that the cost of shadows is held against: Buntin & Stamminger 2007, section 6
KEY = ["scene", "variant", "width", "height", "view", "stress"]  # ratios are taken within one of these


def buildTable(run):
    points = run.points
    table = points[["point_id", "scene", *PLACE_COLUMNS, "technique", *run.axes, "state", "why"]].copy()
    for name in ("frame_ms", "frame_lo", "frame_hi"):
        table[name] = points[name]
    for baseline in BASELINES:
        yardstick = points[points.technique == baseline].drop_duplicates(KEY).set_index(KEY).frame_ms
        own = pandas.MultiIndex.from_frame(points[KEY])
        # The run's own ratio is paired by round, which cancels drift; without one, medians are divided.
        quotient = points.frame_ms / yardstick.reindex(own).to_numpy()
        table[f"to_{baseline}"] = points[f"to_{baseline}"].fillna(quotient)
    table["shadow_to_standard"] = shadowCosts(points, table.to_unshadowed)
    for name in ("error", "half_pixel_sensitivity", "false_shadow", "false_light", "edge_p95"):
        table[name] = points[name]
    table["texture_mib"] = points.texture_bytes / 2**20
    table["pareto"] = ""
    compared = points[~points.technique.isin(BASELINES) & (points.state == "ok")]
    for _, panel in compared.groupby(["group", "view", "stress"], sort=False):
        table.loc[paretoFront(panel), "pareto"] = "yes"
    table["flags"], table["fallback"] = points["flags"], points["fallback"]
    return table


def shadowCosts(points, toUnshadowed):
    """What each point's shadows add to the unshadowed frame, over what those of the standard map add."""
    cost = (toUnshadowed - 1).mask(points.technique.isin(BASELINES))
    size = points["size"] if "size" in points else pandas.Series("", index=points.index)
    standard = points[(points.technique == STANDARD[0]) & (size == STANDARD[1])].drop_duplicates(KEY)
    yardstick = cost[standard.index].where(cost[standard.index] > 0).set_axis(pandas.MultiIndex.from_frame(standard[KEY]))
    return cost / yardstick.reindex(pandas.MultiIndex.from_frame(points[KEY])).to_numpy()


def number(value, form, unit=""):
    return "" if pandas.isna(value) else f"{value:{form}}{unit}"


def share(value):
    return "" if pandas.isna(value) else "0" if value == 0 else f"{value * 100:.3g} %"


def interval(row):
    if pandas.isna(row.frame_ms):
        return ""
    if pandas.isna(row.frame_lo) or pandas.isna(row.frame_hi):
        return f"{row.frame_ms:.2f}"
    return f"{row.frame_ms:.2f} [{row.frame_lo:.2f}, {row.frame_hi:.2f}]"


def notes(row):
    words = {"ok": "", "pruned": "left out: " + row.why, "failed": "failed: " + (row.why or "no reason given"),
             "missing": "not measured"}[row.state]
    return "; ".join(filter(None, [words, row["flags"].replace(";", ", "), row.fallback])).replace("|", "\\|")


def markdown(run, table):
    lines = ["# Error against frame time", "", f"{run.machine}.",
             "Frame time: median [95 % interval]. Ratios are to the frames of the same run; shadow cost: what is added to the "
             f"unshadowed frame, over what {STANDARD[0]} {STANDARD[1]}² adds. "
             "Errors are shares of the pixels whose true label is known. ● marks the Pareto front.", ""]
    heads = ["technique", "settings", "frame ms", "to unshadowed", "shadow cost", "to bare", "error", "false shadow", "false light",
             "edge P95 px", "texture MiB", "", "notes"]
    for group, rows in table.groupby([run.points.group, run.points["view"], run.points.stress], sort=False):
        lines += ["## " + " · ".join(filter(None, group)), "", "| " + " | ".join(heads) + " |",
                  "|---|---|" + "---:|" * 9 + "---|---|"]
        for index, row in rows.iterrows():
            cells = [row.technique, run.points.varies[index], interval(row), number(row.to_unshadowed, ".2f"), number(row.shadow_to_standard, ".2f"),
                     number(row.to_bare, ".2f"), share(row.error), share(row.false_shadow), share(row.false_light),
                     number(row.edge_p95, ".2f"), number(row.texture_mib, ".1f"), "●" if row.pareto else "", notes(row)]
            lines.append("| " + " | ".join(cells) + " |")
        lines.append("")
    if run.leftOut:
        lines += ["## Passes left out", "", "The scene does not need them, and leaving them out changes no pixel.", ""]
        lines += [f"- `{name}`: {reason} ({', '.join(techniques)})" for name, reason, techniques in run.leftOut] + [""]
    return "\n".join(lines)
