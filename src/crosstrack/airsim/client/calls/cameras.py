"""Calls about images, cameras and their lenses."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.client.call import Call, query
from crosstrack.airsim.structs import CameraInfo, DetectionInfo, ImageRequest, ImageResponse, Pose


class Cameras:
    """Calls about images, cameras and their lenses."""

    @query
    def get_images(
        self, requests: Sequence[ImageRequest], vehicle: str = "", external: bool = False
    ) -> Call[tuple[ImageResponse, ...]]:
        """Return images taken at one instant."""
        return Call("simGetImages", requests, vehicle, external)

    @query
    def get_image(self, camera: str, image_type: int, vehicle: str = "", external: bool = False) -> Call[bytes]:
        """Return an image as PNG, empty where there is none."""
        return Call("simGetImage", camera, image_type, vehicle, external)

    @query
    def get_camera_info(self, camera: str, vehicle: str = "", external: bool = False) -> Call[CameraInfo]:
        """Return where a camera is, and what it sees."""
        return Call("simGetCameraInfo", camera, vehicle, external)

    @query
    def set_camera_pose(self, camera: str, pose: Pose, vehicle: str = "", external: bool = False) -> Call[None]:
        """Place a camera on its vehicle."""
        return Call("simSetCameraPose", camera, pose, vehicle, external)

    @query
    def set_camera_fov(self, camera: str, fov: float, vehicle: str = "", external: bool = False) -> Call[None]:
        """Set how wide (deg) a camera sees."""
        return Call("simSetCameraFov", camera, fov, vehicle, external)

    @query
    def get_distortion_params(
        self, camera: str, vehicle: str = "", external: bool = False
    ) -> Call[NDArray[np.float32]]:
        """Return the distortion (5,) of a camera: K1, K2, K3, P1, P2."""
        return Call("simGetDistortionParams", camera, vehicle, external)

    @query
    def set_distortion_param(
        self, camera: str, name: str, value: float, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Set one of K1, K2, K3, P1, P2."""
        return Call("simSetDistortionParam", camera, name, value, vehicle, external)

    @query
    def add_detection_filter_mesh_name(
        self, camera: str, image_type: int, mesh: str, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Have objects of a name, with * for anything, detected."""
        return Call("simAddDetectionFilterMeshName", camera, image_type, mesh, vehicle, external)

    @query
    def set_detection_filter_radius(
        self, camera: str, image_type: int, radius: float, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Have objects within a distance (cm) detected."""
        return Call("simSetDetectionFilterRadius", camera, image_type, radius, vehicle, external)

    @query
    def clear_detection_mesh_names(
        self, camera: str, image_type: int, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Have nothing detected any more."""
        return Call("simClearDetectionMeshNames", camera, image_type, vehicle, external)

    @query
    def get_detections(
        self, camera: str, image_type: int, vehicle: str = "", external: bool = False
    ) -> Call[tuple[DetectionInfo, ...]]:
        """Return the objects that a camera sees, of those to be detected."""
        return Call("simGetDetections", camera, image_type, vehicle, external)

    @query
    def get_preset_lens_settings(self, camera: str, vehicle: str = "", external: bool = False) -> Call[tuple[str, ...]]:
        """Return the lenses that can be chosen."""
        return Call("simGetPresetLensSettings", camera, vehicle, external)

    @query
    def get_lens_settings(self, camera: str, vehicle: str = "", external: bool = False) -> Call[str]:
        """Return the lens."""
        return Call("simGetLensSettings", camera, vehicle, external)

    @query
    def set_preset_lens_settings(
        self, preset: str, camera: str, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Choose a lens."""
        return Call("simSetPresetLensSettings", preset, camera, vehicle, external)

    @query
    def get_preset_filmback_settings(
        self, camera: str, vehicle: str = "", external: bool = False
    ) -> Call[tuple[str, ...]]:
        """Return the image sensors that can be chosen."""
        return Call("simGetPresetFilmbackSettings", camera, vehicle, external)

    @query
    def set_preset_filmback_settings(
        self, preset: str, camera: str, vehicle: str = "", external: bool = False
    ) -> Call[None]:
        """Choose an image sensor."""
        return Call("simSetPresetFilmbackSettings", preset, camera, vehicle, external)

    @query
    def get_filmback_settings(self, camera: str, vehicle: str = "", external: bool = False) -> Call[str]:
        """Return the image sensor."""
        return Call("simGetFilmbackSettings", camera, vehicle, external)

    @query
    def set_filmback_settings(
        self, width: float, height: float, camera: str, vehicle: str = "", external: bool = False
    ) -> Call[float]:
        """Set the size (mm) of the image sensor."""
        return Call("simSetFilmbackSettings", width, height, camera, vehicle, external)

    @query
    def get_focal_length(self, camera: str, vehicle: str = "", external: bool = False) -> Call[float]:
        """Return the focal length, mm."""
        return Call("simGetFocalLength", camera, vehicle, external)

    @query
    def set_focal_length(self, length: float, camera: str, vehicle: str = "", external: bool = False) -> Call[None]:
        """Set the focal length, mm."""
        return Call("simSetFocalLength", length, camera, vehicle, external)

    @query
    def enable_manual_focus(self, enable: bool, camera: str, vehicle: str = "", external: bool = False) -> Call[None]:
        """Let the focus be set, or find itself."""
        return Call("simEnableManualFocus", enable, camera, vehicle, external)

    @query
    def get_focus_distance(self, camera: str, vehicle: str = "", external: bool = False) -> Call[float]:
        """Return the distance of what is sharp, cm."""
        return Call("simGetFocusDistance", camera, vehicle, external)

    @query
    def set_focus_distance(self, distance: float, camera: str, vehicle: str = "", external: bool = False) -> Call[None]:
        """Set the distance of what is sharp, cm."""
        return Call("simSetFocusDistance", distance, camera, vehicle, external)

    @query
    def get_focus_aperture(self, camera: str, vehicle: str = "", external: bool = False) -> Call[float]:
        """Return the aperture, as an f-number."""
        return Call("simGetFocusAperture", camera, vehicle, external)

    @query
    def set_focus_aperture(self, aperture: float, camera: str, vehicle: str = "", external: bool = False) -> Call[None]:
        """Set the aperture, as an f-number."""
        return Call("simSetFocusAperture", aperture, camera, vehicle, external)

    @query
    def enable_focus_plane(self, enable: bool, camera: str, vehicle: str = "", external: bool = False) -> Call[None]:
        """Show what is sharp, or not."""
        return Call("simEnableFocusPlane", enable, camera, vehicle, external)

    @query
    def get_current_field_of_view(self, camera: str, vehicle: str = "", external: bool = False) -> Call[str]:
        """Return how wide the camera sees, in words."""
        return Call("simGetCurrentFieldOfView", camera, vehicle, external)
