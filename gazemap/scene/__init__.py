"""The dense surface, the objects on it and ray casting; a home of open3d."""
