import cv2
import numpy as np
import pytest

from gazemap.errors import InputError
from gazemap.geometry.camera import LensModel
from gazemap.session import open_session

CAMERA = (
    '{"camera_matrix": [[90, 0, 40], [0, 90, 30], [0, 0, 1]], "distortion_coefficients": [0,0,0,0]}'
)
SENSOR = """%YAML:1.0
sensor_type: camera
rate_hz: 20
resolution: [80, 60]
camera_model: pinhole
intrinsics: [90.5, 91.5, 40, 30]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 0.00002]
"""


def write_image(path, value, *, grey=False):
    path.parent.mkdir(parents=True, exist_ok=True)
    shape = (60, 80) if grey else (60, 80, 3)
    assert cv2.imwrite(str(path), np.full(shape, value, dtype=np.uint8))


@pytest.fixture
def tum(tmp_path):
    for i in range(3):
        write_image(tmp_path / "rgb" / f"{i}.png", 20 * i)
    (tmp_path / "rgb.txt").write_text(
        "# timestamp filename\n1305031102.175304 rgb/0.png\n1305031102.211214 rgb/1.png\n"
        "1305031102.3 rgb/2.png\n"
    )
    (tmp_path / "scene_camera.json").write_text(CAMERA)
    return tmp_path


def test_a_tum_folder_has_its_times_to_the_nanosecond(tum):
    session = open_session(tum)
    frames = list(session.scene_frames())
    assert [f.t_ns for f in frames] == [
        1305031102175304000,
        1305031102211214000,
        1305031102300000000,
    ]
    assert [int(f.image[0, 0, 0]) for f in frames] == [0, 20, 40]


def test_depth_of_the_tum_benchmark_has_its_own_unit(tum):
    (tum / "depth").mkdir()
    units = np.full((60, 80), 6250, dtype=np.uint16)
    assert cv2.imwrite(str(tum / "depth" / "0.png"), units)
    (tum / "depth.txt").write_text("# depth maps\n1305031102.18 depth/0.png\n")
    session = open_session(tum)
    (frame,) = session.scene_depth_frames()
    assert frame.depth_m[5, 5] == 1.25
    (coded,) = session.scene_depth.coded()
    depth_mm = cv2.imdecode(np.frombuffer(coded.data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert depth_mm[5, 5] == 1250


def test_registered_depth_is_in_metres_and_nan_where_unknown(tum):
    (tum / "depth").mkdir()
    depth_mm = np.full((60, 80), 1250, dtype=np.uint16)
    depth_mm[0, 0] = 0
    assert cv2.imwrite(str(tum / "depth" / "0.png"), depth_mm)
    with pytest.raises(InputError, match="1 depth images for 3 frames"):
        open_session(tum)
    (tum / "depth.txt").write_text("1305031102.18 depth/0.png\n")
    (frame,) = open_session(tum).scene_depth_frames()
    assert frame.t_ns == 1305031102180000000
    assert frame.depth_m[5, 5] == 1.25
    assert np.isnan(frame.depth_m[0, 0])


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("9 rgb/0.png\n", "line 5: the time is not after"),
        ("1305031103 rgb/9.png\n", "line 5: the image rgb/9.png is missing"),
        ("soon rgb/0.png\n", "line 5: a time in seconds"),
        ("1305031103\n", "line 5: 'seconds file' expected"),
    ],
)
def test_a_wrong_line_of_a_list_is_named(tum, line, said):
    (tum / "rgb.txt").write_text((tum / "rgb.txt").read_text() + line)
    with pytest.raises(InputError, match=said):
        open_session(tum)


def test_an_image_of_another_size_is_refused(tum):
    cv2.imwrite(str(tum / "rgb" / "2.png"), np.zeros((30, 40, 3), dtype=np.uint8))
    with pytest.raises(InputError, match="80x60 pixels expected, got 40x30"):
        list(open_session(tum).scene_frames())


def test_an_image_that_was_cut_is_refused(tum):
    (tum / "rgb" / "1.png").write_bytes(b"")
    with pytest.raises(InputError, match="no image in it"):
        list(open_session(tum).scene_frames())


@pytest.fixture
def euroc(tmp_path):
    cam0 = tmp_path / "mav0" / "cam0"
    for t_ns in (1403636579763555584, 1403636579813555456):
        write_image(cam0 / "data" / f"{t_ns}.png", 99, grey=True)
    (cam0 / "data.csv").write_text(
        "#timestamp [ns],filename\r\n1403636579763555584,1403636579763555584.png\r\n"
        "1403636579813555456,1403636579813555456.png\r\n"
    )
    (cam0 / "sensor.yaml").write_text(SENSOR)
    imu0 = tmp_path / "mav0" / "imu0"
    imu0.mkdir()
    (imu0 / "data.csv").write_text(
        "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
        "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n1403636579758555392,1,2,3,4,5,6\n"
    )
    return tmp_path


@pytest.mark.parametrize("inside", [".", "mav0", "mav0/cam0"])
def test_a_euroc_folder_is_grey_and_has_its_sensor(euroc, inside):
    session = open_session(euroc / inside)
    frames = list(session.scene_frames())
    assert [f.t_ns for f in frames] == [1403636579763555584, 1403636579813555456]
    assert frames[0].image.shape == (60, 80)
    assert (session.scene_camera.K[0, 0], session.scene_camera.K[1, 1]) == (90.5, 91.5)
    np.testing.assert_array_equal(session.data.imu.accel_m_s2, [[4, 5, 6]])


def test_a_euroc_fisheye_is_known_and_a_wrong_sensor_refused(euroc):
    sensor = euroc / "mav0" / "cam0" / "sensor.yaml"
    sensor.write_text(SENSOR.replace("radial-tangential", "equidistant"))
    assert open_session(euroc).scene_camera.lens is LensModel.FISHEYE
    sensor.write_text(SENSOR.replace("radial-tangential", "fov"))
    with pytest.raises(InputError, match="'distortion_model' is 'fov'"):
        open_session(euroc)
    sensor.write_text(SENSOR.replace("[80, 60]", "[752, 480]"))
    with pytest.raises(InputError, match="752x480"):
        open_session(euroc)


def test_images_have_the_times_of_their_names_or_nominal_ones_with_a_warning(tmp_path):
    folder = tmp_path / "shots"
    for name in ("a", "b", "c"):
        write_image(folder / f"{name}.jpg", 50)
    (tmp_path / "scene_camera.json").write_text(CAMERA)
    session = open_session(folder)
    assert np.diff(session.scene_t_ns).tolist() == [33_333_333] * 2
    assert "no times" in session.data.warnings[0]
    for i, path in enumerate(sorted(folder.glob("*.jpg"))):
        path.rename(folder / f"{1760000000000000000 + i * 50}.jpg")
    session = open_session(folder)
    assert np.diff(session.scene_t_ns).tolist() == [50, 50]
    assert session.data.warnings == ()
    (folder / "world_timestamps.csv").write_text("timestamp [ns]\n1\n2\n9\n")
    assert open_session(folder).scene_t_ns == (1, 2, 9)
