"""Calls about objects of the scene."""

from numpy.typing import ArrayLike

from crosstrack.airsim.client.call import Call, query
from crosstrack.airsim.structs import GeoPoint, MeshPositionVertexBuffersResponse, Pose
from crosstrack.types import Array


class Objects:
    """Calls about objects of the scene."""

    @query
    def list_scene_objects(self, pattern: str = ".*") -> Call[tuple[str, ...]]:
        """Return the names of objects that a regular expression matches."""
        return Call("simListSceneObjects", pattern)

    @query
    def list_scene_objects_by_tag(self, pattern: str = ".*") -> Call[tuple[str, ...]]:
        """Return the names of objects with a tag that a regular expression matches; Colosseum alone knows it."""
        return Call("simListSceneObjectsByTag", pattern)

    @query
    def list_assets(self) -> Call[tuple[str, ...]]:
        """Return what can be spawned."""
        return Call("simListAssets")

    @query
    def load_level(self, level: str) -> Call[bool]:
        """Load a level of Unreal's, and return whether it is there."""
        return Call("simLoadLevel", level)

    @query
    def spawn_object(
        self,
        name: str,
        asset: str,
        pose: Pose,
        scale: ArrayLike = (1.0, 1.0, 1.0),
        physics: bool = False,
        blueprint: bool = False,
    ) -> Call[str]:
        """Add an object of a scale (3,), and return the name that it got."""
        return Call("simSpawnObject", name, asset, pose, scale, physics, blueprint)

    @query
    def destroy_object(self, name: str) -> Call[bool]:
        """Take an object away, and return whether there was one."""
        return Call("simDestroyObject", name)

    @query
    def get_object_pose(self, name: str) -> Call[Pose]:
        """Return the pose of an object, NaN where there is none."""
        return Call("simGetObjectPose", name)

    @query
    def set_object_pose(self, name: str, pose: Pose, teleport: bool = True) -> Call[bool]:
        """Move an object, and return whether that was possible."""
        return Call("simSetObjectPose", name, pose, teleport)

    @query
    def get_object_scale(self, name: str) -> Call[Array]:
        """Return the scale (3,) of an object."""
        return Call("simGetObjectScale", name)

    @query
    def set_object_scale(self, name: str, scale: ArrayLike) -> Call[bool]:
        """Set the scale (3,) of an object, and return whether that was possible."""
        return Call("simSetObjectScale", name, scale)

    @query
    def find_look_at_rotation(self, vehicle: str, name: str) -> Call[Array]:
        """Return the angles (3,) at which a vehicle faces an object; Colosseum alone knows it."""
        return Call("simFindLookAtRotation", vehicle, name)

    @query
    def set_segmentation_object_id(self, name: str, number: int, is_pattern: bool = False) -> Call[bool]:
        """Number an object, or those that a regular expression matches, and return whether there are any."""
        return Call("simSetSegmentationObjectID", name, number, is_pattern)

    @query
    def get_segmentation_object_id(self, name: str) -> Call[int]:
        """Return the number of an object, -1 where there is none."""
        return Call("simGetSegmentationObjectID", name)

    @query
    def get_mesh_position_vertex_buffers(self) -> Call[tuple[MeshPositionVertexBuffersResponse, ...]]:
        """Return the meshes of the objects."""
        return Call("simGetMeshPositionVertexBuffers")

    @query
    def get_world_extents(self) -> Call[tuple[GeoPoint, ...]]:
        """Return the two opposite corners of the world."""
        return Call("simGetWorldExtents")

    @query
    def create_voxel_grid(self, centre: ArrayLike, x: int, y: int, z: int, resolution: float, file: str) -> Call[bool]:
        """Write which cells (m) of a box (m) about a point (3,) are occupied to a file of the server's, as binvox."""
        return Call("simCreateVoxelGrid", centre, x, y, z, resolution, file)

    @query
    def set_light_intensity(self, name: str, intensity: float) -> Call[bool]:
        """Set how bright a light is, and return whether there is one."""
        return Call("simSetLightIntensity", name, intensity)

    @query
    def swap_textures(
        self, tags: str, texture: int = 0, component: int = 0, material: int = 0
    ) -> Call[tuple[str, ...]]:
        """Change the texture of objects with tags, and return their names."""
        return Call("simSwapTextures", tags, texture, component, material)

    @query
    def set_object_material(self, name: str, material: str, component: int = 0) -> Call[bool]:
        """Set the material of an object, and return whether that was possible."""
        return Call("simSetObjectMaterial", name, material, component)

    @query
    def set_object_material_from_texture(self, name: str, texture: str, component: int = 0) -> Call[bool]:
        """Make the material of an object of an image, and return whether that was possible."""
        return Call("simSetObjectMaterialFromTexture", name, texture, component)
