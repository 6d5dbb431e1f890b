"""Reading back what a preview has drawn: the tree of Meshcat's server, decoded."""

import numpy as np
import umsgpack
from meshcat.servers.tree import find_node, walk

from srs_ik.preview import Preview


class Scene:
    """What the browsers of a preview are sent."""

    def __init__(self, view: Preview) -> None:
        self.tree = view._window._bridge.tree

    def names(self, prefix: str = "") -> set[str]:
        """Names of the parts of the scene; those below `prefix`."""
        node = find_node(self.tree, ["meshcat", *filter(None, prefix.split("/"))])
        return set(node)

    def transform(self, name: str) -> np.ndarray:
        """(4, 4) where a name is put, in what it is part of."""
        node = find_node(self.tree, ["meshcat", *name.split("/")])
        if node.transform is None:
            return np.eye(4)
        return np.array(umsgpack.unpackb(node.transform)["matrix"], dtype=float).reshape(4, 4).T

    def vertices(self, name: str) -> list[np.ndarray]:
        """(n, 3) vertices of each solid below a name, in the frame of that name."""
        node = find_node(self.tree, ["meshcat", *name.split("/")])
        found = []
        for part in walk(node):
            if part.object is not None:
                (geometry,) = umsgpack.unpackb(part.object)["object"]["geometries"]
                data = geometry["data"]["attributes"]["position"]["array"].data
                found.append(np.frombuffer(data, dtype=np.float32).reshape(-1, 3).astype(float))
        return found

    def solids(self, group: str, joints=range(8)) -> list[np.ndarray]:
        """Vertices of each solid of a robot, in the base frame."""
        return [
            points @ T[:3, :3].T + T[:3, 3]
            for k in joints
            for T in [self.transform(f"{group}/joint {k}")]
            for points in self.vertices(f"{group}/joint {k}")
        ]

    def animated(self) -> dict[str, dict[str, list]]:
        """For each name that moves, its keys of position and quaternion."""
        if self.tree.animation is None:
            return {}
        command = umsgpack.unpackb(self.tree.animation)
        return {
            animation["path"].removeprefix("/meshcat/"): {
                track["name"].lstrip("."): [key["value"] for key in track["keys"]]
                for track in animation["clip"]["tracks"]
            }
            for animation in command["animations"]
        }
