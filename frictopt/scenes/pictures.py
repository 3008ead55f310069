"""The picture of a scene is that of its model."""

from ..fem.pictures import model_picture
from ..plots.draw import draw as draw
from ..plots.style import AnyAxes, picture
from .scene import Scene


@picture.register
def _scene(scene: Scene, ax: AnyAxes = None) -> AnyAxes:
    return model_picture(scene.model(), ax)
