"""What all figures share: look, layout, and files that are the same bytes for the same input."""
import textwrap
from dataclasses import dataclass

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

# Okabe & Ito 2008, told apart by colour-blind readers; their yellow is too pale for lines on white.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MARKERS = ["o", "s", "D", "^", "v", "P", "X", "h"]
MUTED = "#666666"
LINE = 0.145  # inches: height of a line of notes
LEAST_PANEL = 2.2  # inches: narrower panels have their legend below

matplotlib.rcParams.update({
    "svg.hashsalt": "dapple", "font.family": "DejaVu Sans", "font.size": 9, "axes.spines.top": False,
    "axes.spines.right": False, "axes.edgecolor": "#444444", "axes.linewidth": 0.8, "figure.facecolor": "white",
    "legend.frameon": False, "path.simplify": False,
    # Publishers refuse Type 3 fonts; text of an SVG stays text; names of scenes and views are no formulas.
    "pdf.fonttype": 42, "ps.fonttype": 42, "svg.fonttype": "none", "text.parse_math": False,
})
# Nothing that changes from run to run: no date, no version of the tools.
METADATA = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None},
            "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}


@dataclass
class Page:
    """What a person asks of all figures. Texts have their size in points at this width: figures are made to be printed as they are."""
    width: float = 0  # inches; 0: as wide as the panels want
    title: bool = True


PAGE = Page()


def plainSize(points):
    """Points of a text that is `points` on a free page; a column of a paper is set smaller."""
    return points if not PAGE.width else max(6, points - 1)


@dataclass
class Texts:
    title: str
    machine: str
    notes: list


def layout(panel, columns, texts, handles, rows, above=0.25, below=0.5, left=0.8, gaps=(0.22, 0.32), **options):
    """A figure with its texts and its legend, and its panels. `panel`: (width, height) in inches of one panel where the page is free;
    `rows`: a height for each row, in shares of the panel's. Other lengths in inches. `options` go to pyplot.subplots."""
    legend = 0.6 + 0.062 * max((len(handle.get_label()) for handle in handles), default=0) if handles else 0.2
    width = PAGE.width or panel[0] * columns + left + legend
    beside = (width - left - legend) / columns >= (LEAST_PANEL if PAGE.width else 0)
    panelWidth = (width - left - (legend if beside else 0.15)) / columns
    panelHeight = panel[1] if not PAGE.width else max(panel[1] * panelWidth / panel[0], min(1.9, panel[1]))
    legendColumns = max(1, int((width - 0.2) / legend)) if handles else 1
    legendHeight = 0 if beside or not handles else 0.17 * -(-len(handles) // legendColumns) + 0.15
    lines = [line for note in texts.notes for line in textwrap.wrap(note, int(width * 15), subsequent_indent="    ")]
    title, machine = textwrap.wrap(texts.title, int(width * 8.5)), textwrap.wrap(texts.machine, int(width * 12.5))
    head = 0.24 + 0.2 * len(title) + 0.14 * len(machine) if PAGE.title else 0.05
    foot = 0.16 + LINE * len(lines) + legendHeight
    inner = panelHeight * sum(rows)
    height = inner + head + foot + above + below
    figure, panels = plt.subplots(len(rows), columns, figsize=(width, height), squeeze=False, height_ratios=rows, **options)
    figure.subplots_adjust(left=left / width, right=1 - (legend if beside else 0.15) / width, bottom=(foot + below) / height,
                           top=1 - (head + above) / height, wspace=gaps[0], hspace=gaps[1])
    if PAGE.title:
        figure.text(0.02, 1 - 0.10 / height, "\n".join(title), fontsize=plainSize(12), fontweight="bold", va="top")
        figure.text(0.02, 1 - (0.16 + 0.2 * len(title)) / height, "\n".join(machine), fontsize=plainSize(9), color=MUTED, va="top")
    figure.text(0.02, 0.08 / height, "\n".join(lines), fontsize=plainSize(7.5), color=MUTED, va="bottom", linespacing=1.3)
    if handles and beside:
        figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(1 - (legend - 0.05) / width, 1 - (head + 0.1) / height),
                      fontsize=plainSize(8), labelspacing=0.7)
    elif handles:
        figure.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.01, (foot - legendHeight) / height), ncol=legendColumns,
                      fontsize=plainSize(8), columnspacing=1.2, borderaxespad=0.2)
    return figure, panels


def save(figure, stem):
    """Writes stem.svg, .png and .pdf, each whole or not at all; returns their paths."""
    paths = []
    for form, metadata in METADATA.items():
        path = stem.with_name(f"{stem.name}.{form}")
        temporary = path.with_name(path.name + ".tmp")
        try:
            figure.savefig(temporary, format=form, dpi=160, metadata=metadata)
            temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
        paths.append(path)
    plt.close(figure)
    return paths
