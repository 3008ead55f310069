"""What all scenes share."""

from ..contact.show import Plotted
from ..fem.model import ContactModel


class Scene(Plotted):
    """Base of scenes."""

    def model(self) -> ContactModel:
        """The model of the scene."""
        raise NotImplementedError
