"""One session rebuilt: each stage once, its files as soon as it is finished."""

import importlib.metadata
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

import cv2
import numpy as np

from gazemap.errors import InputError
from gazemap.pipeline import (
    Located,
    Looks,
    MappingConfig,
    find_looks,
    locate_cameras,
    model_scene,
)
from gazemap.ports import Progress, Session
from gazemap.scene.mesh_file import write_mesh
from gazemap.session.atomic import whole_file, whole_folder
from gazemap.session.opening import open_session
from gazemap.session.tum_file import write_tum
from gazemap.slam.colmap import write_colmap
from gazemap.types.scene import SceneModel
from grounding.exports import to_behavior_tree, to_json_lines, to_pddl, to_pddl_domain
from grounding.patches.patch import PATCH_COLUMNS, Patch
from grounding.pipeline import GroundingConfig, SessionGrounding
from grounding.plan import GroundedPlan
from grounding.symbols.document import to_json
from services.rebuild.grounding_stage import Mapped, ground
from services.rebuild.outputs import (
    Membership,
    objects_document,
    write_fixations,
    write_json,
    write_rows,
)
from services.rebuild.stages import Outcome, Stages, input_key
from services.rebuild.summary import summary_document
from services.report.sections import write_report

_VERSIONS: Final = ("gazemap", "pycolmap", "open3d-cpu", "gtsam", "opencv-python-headless", "numpy")


@dataclass(frozen=True, slots=True, kw_only=True)
class RebuildConfig:
    """How a session is rebuilt."""

    mapping: MappingConfig = field(default_factory=MappingConfig)
    grounding: GroundingConfig = field(default_factory=GroundingConfig)
    with_narration_times: bool = True
    camera: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Rebuilt:
    """A session with all that was made of it."""

    mapped: Mapped
    grounded: SessionGrounding

    @property
    def memberships(self) -> dict[int, Membership]:
        """To which instruction each fixation belongs, by its id."""
        return {
            look.fixation_id: Membership(instruction=look.instruction, probability=look.probability)
            for look in self.grounded.looks
        }


def rebuild(path: Path, out: Path, config: RebuildConfig, *, progress: Progress) -> Rebuilt:
    """Rebuild a session into a folder; stages that were finished before are taken from there.

    Raises:
        GazemapError: if the input cannot be used; what was finished stays, nothing is half written.
    """
    check_place(out, path)
    session = open_session(path, camera=config.camera)
    check_narration(session, path)
    stages = Stages(folder=out / ".stages", key=input_key(path))
    located = _locate(session, config, stages, progress=progress)
    write_path(located, out)
    scene = _model(session, located, config, stages, progress=progress)
    write_mesh(scene.mesh, out / "scene.ply")
    looks = _look(session, located, scene, config, stages)
    mapped = Mapped(session=session, located=located, scene=scene, looks=looks)
    rebuilt = Rebuilt(mapped=mapped, grounded=_ground(mapped, config, stages))
    write_grounding(rebuilt, out)
    summary = summary_document(mapped, stages.reports, versions())
    write_json(out / "summary.json", summary)
    write_report(rebuilt, summary, out / "report.html")
    return rebuilt


def check_place(out: Path, session: Path) -> None:
    """Refuse to write into a session: a rebuild never changes its input."""
    if session.is_dir() and out.resolve().is_relative_to(session.resolve()):
        raise InputError("it lies in the session", where=out, todo="name a folder outside of it")


def check_narration(session: Session, path: Path) -> None:
    """Refuse a narration file that says nothing: a session without one is another matter."""
    has_file = path.is_dir() and (path / "narration.vtt").exists()
    if has_file and not session.data.narration:
        todo = "transcribe the session, or remove the file to rebuild it without a plan"
        raise InputError("no cue in it", where=path / "narration.vtt", todo=todo)


def _locate(
    session: Session, config: RebuildConfig, stages: Stages, *, progress: Progress
) -> Located:
    def work() -> Outcome[Located]:
        located = locate_cameras(session, config.mapping, progress=progress)
        messages = [*session.data.warnings, *located.slam.warnings]
        if session.overhead_camera is not None and located.T_world_overhead is None:
            messages.append(
                "the overhead camera is not located: it sees no tag of the layout, and too little "
                "of what the head sees of the table"
            )
        return Outcome(result=located, messages=tuple(messages))

    return stages.run("mapping", work, options=(config.mapping.slam, config.camera))


def _model(
    session: Session, located: Located, config: RebuildConfig, stages: Stages, *, progress: Progress
) -> SceneModel:
    def work() -> Outcome[SceneModel]:
        scene = model_scene(session, located, config.mapping, progress=progress)
        messages = () if scene.objects else ("no objects were found on the table",)
        return Outcome(result=scene, messages=messages)

    return stages.run("scene", work, options=config.mapping.scene)


def _look(
    session: Session, located: Located, scene: SceneModel, config: RebuildConfig, stages: Stages
) -> Looks:
    mapping = config.mapping

    def work() -> Outcome[Looks]:
        looks = find_looks(session, located, scene, mapping)
        messages = () if looks.fixations else ("the session has no fixations and no gaze",)
        return Outcome(result=looks, messages=messages)

    options = (
        mapping.fixations,
        mapping.offset,
        mapping.noise,
        mapping.source,
        mapping.offset_mode,
    )
    return stages.run("fixations", work, options=options)


def _ground(mapped: Mapped, config: RebuildConfig, stages: Stages) -> SessionGrounding:
    def work() -> Outcome[SessionGrounding]:
        times = config.with_narration_times
        grounded = ground(mapped, config.grounding, with_narration_times=times)
        messages = tuple(f"{u.sentence!r}: {u.reason}" for u in grounded.plan.unparsed)
        return Outcome(result=grounded, messages=messages)

    return stages.run("grounding", work, options=(config.grounding, config.with_narration_times))


def write_path(located: Located, out: Path) -> None:
    """Write the head camera's path and the sparse map."""
    write_tum(located.slam.trajectory, out / "trajectory.tum")
    with whole_folder(out / "map") as partial:
        write_colmap(located.slam, partial)


def write_grounding(rebuilt: Rebuilt, out: Path) -> None:
    """Write objects, fixations, patches and the plan."""
    grounded, mapped = rebuilt.grounded, rebuilt.mapped
    objects = objects_document(mapped.scene.objects, object_symbols(grounded))
    write_json(out / "objects.json", objects)
    write_fixations(out / "fixations3d.csv", mapped.looks.fixations, rebuilt.memberships)
    write_json(out / "plan.json", grounded.plan.to_json())
    write_exports(grounded.plan, out / "exports")
    with whole_file(out / "symbols.json") as partial:
        partial.write_text(to_json(grounded.symbols) + "\n")
    write_patches(grounded.patches, out)


def write_exports(plan: GroundedPlan, folder: Path) -> None:
    """Write the plan in the forms that planners and robots read."""
    with whole_folder(folder) as partial:
        (partial / "plan.jsonl").write_text(to_json_lines(plan))
        (partial / "domain.pddl").write_text(to_pddl_domain(plan))
        (partial / "problem.pddl").write_text(to_pddl(plan))
        (partial / "plan.xml").write_text(to_behavior_tree(plan))


def object_symbols(grounded: SessionGrounding) -> dict[str, tuple[str, ...]]:
    """Return the words of each object that an instruction is surely about."""
    return {
        each.target.object_id: each.spoken.instruction.target
        for each in grounded.plan.instructions
        if each.target is not None and each.target.object_id is not None
    }


def write_patches(patches: tuple[Patch, ...], out: Path) -> None:
    """Write the images of all patches that were cut, and a row for each that was tried."""
    with whole_folder(out / "patches") as partial:
        for each in patches:
            if each.image_bgr is not None:
                cv2.imwrite(str(partial / each.name), np.ascontiguousarray(each.image_bgr))
    write_rows(out / "patches.csv", PATCH_COLUMNS, [each.row() for each in patches])


def versions() -> dict[str, str]:
    """Return the versions of what made the result."""
    return {name: importlib.metadata.version(name) for name in _VERSIONS}
