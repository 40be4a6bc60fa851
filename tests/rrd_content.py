"""What is in rerun files: read back by rerun itself."""

import re

import numpy as np
from rerun.chunk import RrdReader

UUID = re.compile(r"[0-9a-f]{8}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{4}-[0-9a-f]{12}")
NANO = 1e-9


class RrdContent:
    """The entities of a file's recording, and the views of its blueprint."""

    def __init__(self, path):
        reader = RrdReader(str(path))
        self.application = (reader.recordings() or reader.blueprints())[0].application_id
        self._chunks = list(reader.stream()) if reader.recordings() else []
        self._blueprint = list(reader.stream(store=reader.blueprints()[0]))

    @property
    def entities(self):
        return {chunk.entity_path for chunk in self._chunks}

    def column(self, entity, name):
        """All values of a component, as lists in the order of the file."""
        found = []
        for chunk in self._chunks:
            batch = chunk.to_record_batch()
            if chunk.entity_path == entity and name in batch.schema.names:
                found += batch.column(name).to_pylist()
        assert found, f"{entity} has no {name}; there are {sorted(self.entities)}"
        return found

    def curve(self, entity):
        """Times [s] and values (n,) of scalars over time."""
        times, values = [], []
        for chunk in self._chunks:
            batch = chunk.to_record_batch()
            if chunk.entity_path == entity and "Scalars:scalars" in batch.schema.names:
                times.append(np.asarray(batch.column("t").cast("int64")) * NANO)
                values.append(np.array([each[0] for each in batch.column("Scalars:scalars").to_pylist()]))
        assert times, f"{entity} has no scalars; there are {sorted(self.entities)}"
        order = np.argsort(np.concatenate(times), kind="stable")
        return np.concatenate(times)[order], np.concatenate(values)[order]

    def name(self, entity):
        """The name that a curve bears."""
        return self.column(entity, "SeriesLines:names")[0][0]

    def words(self, sheet):
        """What is written on a sheet, and where (n, 2)."""
        texts = self.column(f"{sheet}/words", "Points2D:labels")[0]
        return dict(zip(texts, self.column(f"{sheet}/words", "Points2D:positions")[0], strict=True))

    def strips(self, entity):
        """The lines of a sheet's entity, each (n, 2)."""
        return [np.array(strip) for strip in self.column(entity, "LineStrips2D:strips")[0]]

    def text(self, entity):
        return self.column(entity, "TextDocument:text")[0][0]

    @property
    def view_names(self):
        """The names of all views and tabs."""
        names = set()
        for chunk in self._blueprint:
            batch = chunk.to_record_batch()
            for name in batch.schema.names:
                if name.endswith(":display_name"):
                    names |= {each[0] for each in batch.column(name).to_pylist()}
        return names

    @property
    def layout(self):
        """The blueprint without the names that rerun draws by lot: comparable from file to file."""
        found = []
        for chunk in self._blueprint:
            batch = chunk.to_record_batch()
            columns = [name for name in batch.schema.names if ":" in name]
            held = {name: _plain(batch.column(name).to_pylist()) for name in columns}
            found.append(f"{UUID.sub('*', chunk.entity_path)} {sorted(held.items())}")
        return sorted(found)


def _plain(values):
    """Values as text; ids, as bytes or as text, are left out."""
    if isinstance(values, bytes):
        return "*"
    if isinstance(values, (list, tuple)):
        if len(values) == 16 and all(isinstance(value, int) for value in values):
            return "*"
        return [_plain(value) for value in values]
    if isinstance(values, dict):
        return {key: _plain(value) for key, value in values.items()}
    return UUID.sub("*", str(values))
