"""The description on a package index: README.md with links and pictures that lead somewhere from there too."""

import os
import re
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

LINK = re.compile(
    r"(!?)\[([^\]]*)\]\((?!https?://|#)([^)\s]+)\)"
)  # a picture or a link to a file of the repository


def description(readme: str, repository: str, version: str) -> str:
    """The text with absolute links into the repository at a version; without an address the names of links alone, and no pictures."""
    if not repository:
        return LINK.sub(lambda match: "" if match[1] else match[2], readme)
    return LINK.sub(
        lambda match: (
            f"{match[1]}[{match[2]}]({repository}/{'raw' if match[1] else 'blob'}/{version}/{match[3]})"
        ),
        readme,
    )


class Description(MetadataHookInterface):
    """Sets `readme` and `urls`; the workflow of a release knows the address of the repository, a build elsewhere need not."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in what depends on where the repository is."""
        repository = os.environ.get("FRICTOPT_REPOSITORY", "")
        with open(os.path.join(self.root, "README.md"), encoding="utf-8") as file:
            text = description(file.read(), repository, os.environ.get("FRICTOPT_TAG", "main"))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
        metadata["urls"] = (
            {"Source": repository, "Changes": f"{repository}/blob/main/CHANGELOG.md"}
            if repository
            else {}
        )
