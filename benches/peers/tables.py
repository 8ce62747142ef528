"""What was measured, as Markdown."""


def table(head, rows):
    rows = [head, ["---"] + ["--:"] * (len(head) - 1), *rows]
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def ms(spread, scale=1.0):
    low, high = (f"{spread[key] * scale:.1f}" for key in ("min", "max"))
    return f"{spread['median'] * scale:.1f} ({low}–{high})"


def resample_table(rows, counterpart):
    """A row for each library and filter: the fastest way for each of both, and how many times as long
    as uvgraft it takes for the whole job."""
    lines = []
    for direction in dict.fromkeys(row["direction"] for row in rows):
        here = [row for row in rows if row["direction"] == direction]
        ours = {row["name"]: row["ms"]["median"] for row in here if row["name"].startswith("uvgraft")}
        for name in dict.fromkeys(row["name"] for row in here):
            best = {}
            for row in sorted(here, key=lambda row: row["ms"]["median"]):
                if row["name"] == name:
                    best.setdefault(row["what"], row)
            job, alone = best["whole job"], best.get("alone")
            filter = next((ours for theirs, ours in counterpart.items() if theirs in name), None)
            ratio = f"{job['ms']['median'] / ours[f'uvgraft {filter}']:.2f}" if alone else "1"
            cells = [name, direction, ms(alone["ms"]) if alone else "–", ms(job["ms"])]
            lines.append([*cells, job["way"], f"{ratio} × {filter}" if alone else "–"])
    head = ["", "direction", "alone, ms", "whole job, ms", "fastest way", "whole job takes"]
    return table(head, lines)


def files_table(rows):
    lines = []
    for row in rows:
        same = [other for other in rows if all(other[key] == row[key] for key in ("direction", "image"))]
        ours = next(other for other in same if other["program"] == "uvgraft")
        ratio = [
            f"{row[key]['median'] / ours[key]['median']:.2f}" for key in ("wall_s", "cpu_s", "peak_bytes")
        ]
        title = {"imports": "(Python's imports alone)"}.get(row["program"], row["program"])
        output = f"{row['output_bytes'] / 1e6:.1f}" if "output_bytes" in row else "–"
        cells = [title, row["direction"], row["image"], ms(row["wall_s"], 1e3), ms(row["cpu_s"], 1e3)]
        cells += [f"{row['peak_bytes']['median'] / 1e6:.0f}", output, " / ".join(ratio)]
        lines.append(cells)
    head = ["", "direction", "image", "wall, ms", "processor, ms", "peak, MB", "output, MB"]
    return table([*head, "wall / processor / peak, times uvgraft's"], lines)


def differences_table(rows):
    lines = [
        [row["texels"], row["direction"], row["image"], str(row["count"]), f"{row['max']:.0f}", f"{row['mean']:.3f}"]
        for row in rows
    ]
    return table(["texels", "direction", "image", "count", "greatest", "mean"], lines)
