"""Tells by suite how many files are right, and names those that are not."""

import re
from collections import Counter, defaultdict

from peers.outcome import FAILED, RIGHT, VERDICTS, WRONG


def is_bad(outcomes):
    """Whether any file is wrong or failed."""
    return any(outcome.verdict in (WRONG, FAILED) for _, _, outcome in outcomes)


def line(folder, kind, path, outcome):
    """Describe the outcome of a file."""
    difference = "" if outcome.difference is None else f", difference {outcome.difference:.4g}"
    reason = f": {outcome.reason}" if outcome.reason else ""
    return f"{outcome.verdict}: {path.relative_to(folder)} ({kind}{difference}){reason}"


def text(folder, outcomes):
    """Return the report, in Markdown."""
    suites = defaultdict(list)
    for kind, path, outcome in outcomes:
        inside = path.relative_to(folder).parts
        suites[inside[0] if len(inside) > 1 else ".", kind].append((kind, path, outcome))
    parts = [_table(suites)]
    for (suite, kind), found in sorted(suites.items()):
        lines = [*_named(folder, found), *_reasons(folder, found)]
        if lines:
            parts.append("\n".join([f"## {suite}, {kind}", "", *lines]))
    return "\n\n".join(parts)


def _table(suites):
    lines = [f"| suite | kind | files | {' | '.join(VERDICTS)} |", f"|---|---|{'--:|' * 7}"]
    total = Counter()
    for (suite, kind), found in sorted(suites.items()):
        counts = Counter(outcome.verdict for _, _, outcome in found)
        total += counts
        lines.append(_row(suite, kind, counts))
    return "\n".join([*lines, _row("all", "", total)])


def _row(suite, kind, counts):
    numbers = " | ".join(str(counts[verdict]) for verdict in VERDICTS)
    return f"| {suite} | {kind} | {counts.total()} | {numbers} |"


def _named(folder, found):
    """Name each file that is wrong or failed."""
    bad = [entry for entry in found if entry[2].verdict in (WRONG, FAILED)]
    return [f"- {line(folder, *entry)}" for entry in bad]


def _reasons(folder, found):
    """Count the others that are not right by their reason, each with its shortest path."""
    groups = defaultdict(list)
    for _, path, outcome in found:
        if outcome.verdict not in (RIGHT, WRONG, FAILED):
            reason = general(outcome.reason, path)
            groups[outcome.verdict, reason].append(path.relative_to(folder))
    groups = sorted(groups.items(), key=lambda group: (VERDICTS.index(group[0][0]), -len(group[1])))
    return [
        f"- {verdict}, {len(paths)} × {reason or 'no reason'}, "
        f"such as {min(paths, key=lambda path: len(str(path)))}"
        for (verdict, reason), paths in groups
    ]


def general(reason, path):
    """Return a reason without what differs from file to file: its path and numbers."""
    reason = reason.replace(str(path), "").replace(path.name, "").lstrip(": ")
    reason = re.sub(r"\"[^\"]*\"|'[^']*'", "'…'", reason)
    return re.sub(r"\d+(\.\d+)?", "#", reason)[:160]
