"""Formats the measurements as Markdown tables."""


def table(head, rows):
    rows = [head, ["---"] + ["--:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def ms(spread, scale=1.0):
    low, high = (f"{spread[key] * scale:.1f}" for key in ("min", "max"))
    return f"{spread['median'] * scale:.1f} ({low}–{high})"


def resample_table(rows, counterpart):
    """A row per library and filter: the fastest method for "alone" and "whole job", and the time of the
    whole job as a multiple of uvgraft's."""
    lines = []
    for direction in dict.fromkeys(row["direction"] for row in rows):
        fastest = {}
        for row in sorted(rows, key=lambda row: row["ms"]["median"]):
            if row["direction"] == direction:
                fastest.setdefault(row["name"], {}).setdefault(row["what"], row)
        for name in dict.fromkeys(row["name"] for row in rows):
            job, alone = fastest[name]["whole job"], fastest[name].get("alone")
            filter = next((ours for theirs, ours in counterpart.items() if theirs in name), None)
            cells = [name, direction, ms(alone["ms"]) if alone else "–", ms(job["ms"]), job["way"]]
            if filter:
                ours = fastest[f"uvgraft {filter}"]["whole job"]
                ratio = job["ms"]["median"] / ours["ms"]["median"]
                cells.append(f"{ratio:.2f} × {filter}")
            else:
                cells.append("–")
            lines.append(cells)
    head = ["", "direction", "alone, ms", "whole job, ms", "fastest way"]
    return table([*head, "whole job, times uvgraft's"], lines)


def files_table(rows):
    lines = []
    for row in rows:
        same = [
            other
            for other in rows
            if all(other[key] == row[key] for key in ("direction", "image", "writer"))
        ]
        ours = next(other for other in same if other["program"] == "uvgraft")
        ratio = [
            f"{row[key]['median'] / ours[key]['median']:.2f}"
            for key in ("wall_s", "cpu_s", "peak_bytes")
        ]
        title = {"imports": "(Python's imports alone)"}.get(row["program"], row["program"])
        output = f"{row['output_bytes'] / 1e6:.1f}" if "output_bytes" in row else "–"
        cells = [
            title,
            row["direction"],
            f"{row['image']}, by {row['writer']}",
            ms(row["wall_s"], 1e3),
            ms(row["cpu_s"], 1e3),
        ]
        cells += [f"{row['peak_bytes']['median'] / 1e6:.0f}", output, " / ".join(ratio)]
        lines.append(cells)
    head = ["", "direction", "image", "wall, ms", "processor, ms", "peak, MB", "output, MB"]
    return table([*head, "wall / processor / peak, times uvgraft's"], lines)


def writers_line(rows):
    """How much more processor time uvgraft takes for what Pillow has written."""
    found = {}
    for row in rows:
        if row["program"] == "uvgraft":
            kind = found.setdefault(f"{row['image']} {row['direction']}", {})
            kind[row["writer"]] = row["cpu_s"]["median"]
    ratios = [f"{kind} {times['Pillow'] / times['OpenCV']:.2f}" for kind, times in found.items()]
    return f"uvgraft's processor time for files by Pillow, times that by OpenCV: {', '.join(ratios)}"


def differences_table(rows):
    lines = [
        [
            row["texels"],
            row["direction"],
            row["image"],
            str(row["count"]),
            f"{row['max']:.0f}",
            f"{row['mean']:.3f}",
        ]
        for row in rows
    ]
    return table(["texels", "direction", "image", "count", "greatest", "mean"], lines)
