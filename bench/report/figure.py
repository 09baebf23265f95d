"""What all figures share: look, and files that are the same bytes for the same input."""
import textwrap

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

# Okabe & Ito 2008, told apart by colour-blind readers; their yellow is too pale for lines on white.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000"]
MARKERS = ["o", "s", "D", "^", "v", "P", "X", "h"]
MUTED = "#666666"

matplotlib.rcParams.update({
    "svg.hashsalt": "dapple", "font.family": "DejaVu Sans", "font.size": 9, "axes.spines.top": False,
    "axes.spines.right": False, "axes.edgecolor": "#444444", "axes.linewidth": 0.8, "figure.facecolor": "white",
    "legend.frameon": False, "path.simplify": False,
})
# Nothing that changes from run to run: no date, no version of the tools.
METADATA = {"svg": {"Date": None, "Creator": None}, "png": {"Software": None},
            "pdf": {"CreationDate": None, "Creator": None, "Producer": None}}


def addTexts(figure, title, subtitle, notes, width):
    """Title and subtitle above the axes, notes below; heights in inches, so that they fit figures of any height.
    Returns the share of the figure's height left for the axes, from below: (bottom, top)."""
    inches = figure.get_figheight()
    lines = [line for note in notes for line in textwrap.wrap(note, width, subsequent_indent="    ")]
    figure.text(0.02, 1 - 0.10 / inches, title, fontsize=12, fontweight="bold", va="top")
    figure.text(0.02, 1 - 0.36 / inches, subtitle, fontsize=9, color=MUTED, va="top")
    figure.text(0.02, 0.08 / inches, "\n".join(lines), fontsize=7.5, color=MUTED, va="bottom", linespacing=1.3)
    return (0.16 + 0.145 * len(lines)) / inches, 1 - 0.58 / inches


def save(figure, stem):
    """Writes stem.svg, .png and .pdf, each whole or not at all; returns their paths."""
    paths = []
    for form, metadata in METADATA.items():
        path = stem.with_name(f"{stem.name}.{form}")
        temporary = path.with_name(path.name + ".tmp")
        figure.savefig(temporary, format=form, dpi=160, metadata=metadata)
        temporary.replace(path)
        paths.append(path)
    plt.close(figure)
    return paths
