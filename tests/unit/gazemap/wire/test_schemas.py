import re
from pathlib import Path

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool

from gazemap.wire.schemas import SCHEMAS, schema_data
from gazemap.wire.streams import Stream

DOCUMENT = Path(__file__).resolve().parents[4] / "docs" / "streams.md"


def test_every_stream_stands_in_the_document_with_its_schema():
    rows = [line for line in DOCUMENT.read_text().splitlines() if line.startswith("| `")]
    named = {}
    for row in rows:
        names, schema = row.split("|")[1:3]
        for name in re.findall(r"`([^`]+)`", names):
            named[name] = re.findall(r"`([^`]+)`", schema)[0]
    assert set(named) == {stream.value for stream in Stream}
    for stream, schema in SCHEMAS.items():
        assert named[stream.value] == schema.full_name


def test_a_schema_is_complete_without_us():
    for schema in SCHEMAS.values():
        pool = DescriptorPool()
        for file in FileDescriptorSet.FromString(schema_data(schema)).file:
            pool.Add(file)
        assert pool.FindMessageTypeByName(schema.full_name).full_name == schema.full_name
