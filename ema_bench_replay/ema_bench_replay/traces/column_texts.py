"""The cells of a trace's column as they are written, where they hold words in place of numbers."""

from __future__ import annotations

from itertools import islice

from ema_bench_replay.recording_file import open_recording
from ema_bench_replay.traces.quoted_cells import with_marks_shown
from ema_bench_replay.traces.trace_rows import RowReader
from ema_bench_replay.traces.trace_table import TraceTable
from ema_bench_replay.traces.trace_text import trace_text


def column_texts(table: TraceTable, place: int, most: int) -> list[str]:
    """The texts of the column at a place of the header, in the first rows of a table: up to ``most``.

    Empty if its columns are not those of the file, and fewer if the rows are longer than a block of the file.
    """
    with open_recording(table.path) as file:
        text = trace_text(table.path, file, None)
        body, _ = next(text.blocks)
    rows = RowReader(table.path, text.header.text, text.header.line, body, None, None, lambda header: ())
    if rows.header != table.header:  # pairs of columns got a common time
        return []
    left_out = {*table.left_out}
    cells = (row[place] for k, row in enumerate(rows.texts(body)) if k not in left_out and len(row) == len(rows.header))
    return [with_marks_shown(cell) for cell in islice(cells, most)]
