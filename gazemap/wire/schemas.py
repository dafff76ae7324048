"""The schema of every stream, as a recording stores it and the bus names it."""

from typing import Final

from foxglove_schemas_protobuf.CameraCalibration_pb2 import CameraCalibration
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.CompressedVideo_pb2 import CompressedVideo
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor import Descriptor, FileDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet

from gazemap.wire.generated import gazemap_grounding_pb2 as grounding
from gazemap.wire.generated import gazemap_streams_pb2 as streams
from gazemap.wire.streams import Stream

# An image stream may be either; its packets then say which they are.
VIDEO: Final[Descriptor] = CompressedVideo.DESCRIPTOR
SCHEMAS: Final[dict[Stream, Descriptor]] = {
    Stream.SESSION: streams.SessionInfo.DESCRIPTOR,
    Stream.TAGS: streams.TagLayout.DESCRIPTOR,
    Stream.HEAD_IMAGE: CompressedImage.DESCRIPTOR,
    Stream.HEAD_CALIBRATION: CameraCalibration.DESCRIPTOR,
    Stream.OVERHEAD_IMAGE: CompressedImage.DESCRIPTOR,
    Stream.OVERHEAD_CALIBRATION: CameraCalibration.DESCRIPTOR,
    Stream.GAZE: streams.GazeSample.DESCRIPTOR,
    Stream.DEVICE_FIXATION: streams.DeviceFixation.DESCRIPTOR,
    Stream.BLINK: streams.Blink.DESCRIPTOR,
    Stream.EVENT: streams.Event.DESCRIPTOR,
    Stream.IMU: streams.ImuSample.DESCRIPTOR,
    Stream.NARRATION: streams.NarrationCue.DESCRIPTOR,
    Stream.DEPTH: CompressedImage.DESCRIPTOR,
    Stream.OVERHEAD_DEPTH: CompressedImage.DESCRIPTOR,
    Stream.POSE: PoseInFrame.DESCRIPTOR,
    Stream.FIXATION: streams.Fixation3D.DESCRIPTOR,
    Stream.OBJECT: streams.SceneObject.DESCRIPTOR,
    Stream.MAP_POINTS: PointCloud.DESCRIPTOR,
    Stream.MAP_MESH: SceneUpdate.DESCRIPTOR,
    Stream.MAP_EVENT: streams.MapEvent.DESCRIPTOR,
    Stream.OVERHEAD_POSE: FrameTransform.DESCRIPTOR,
    Stream.MAPPING_STATUS: streams.ServiceStatus.DESCRIPTOR,
    Stream.PLAN: grounding.Plan.DESCRIPTOR,
    Stream.INSTRUCTION: grounding.Instruction.DESCRIPTOR,
    Stream.SYMBOLS: grounding.Symbols.DESCRIPTOR,
    Stream.QUESTION: grounding.Question.DESCRIPTOR,
    Stream.GROUNDING_STATUS: streams.ServiceStatus.DESCRIPTOR,
}


def schema_data(schema: Descriptor) -> bytes:
    """Return a message's file with all it imports, as a serialized FileDescriptorSet."""
    files: dict[str, FileDescriptor] = {}

    def add(file: FileDescriptor) -> None:
        if file.name not in files:
            for needed in file.dependencies:
                add(needed)
            files[file.name] = file

    add(schema.file)
    protos = FileDescriptorSet()
    for file in files.values():
        proto = FileDescriptorProto()
        file.CopyToProto(proto)
        protos.file.append(proto)
    return protos.SerializeToString()
