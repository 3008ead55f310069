"""An executor of tests, whose tasks end as the test wants."""

from concurrent.futures import Executor, Future


class Foreign(Executor):
    """An executor that hands out what `answer` makes of a task's rows, and takes `most` tasks."""

    def __init__(self, answer, most=999, kind=Future):
        self.answer, self.most, self.kind, self.sizes = answer, most, kind, []

    def submit(self, follow, batch):
        if len(self.sizes) == self.most:
            raise OSError("link down")
        self.sizes.append(len(batch))
        future = self.kind()
        self.answer(future, follow(batch))
        return future
