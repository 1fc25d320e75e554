"""Drive one FMI 2.0 co-simulation FMU by hand, with its log."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import fmpy
import fmpy.model_description
import numpy as np
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)


class Slave:
    """An instance, addressed by port names; ``log`` collects its messages."""

    def __init__(self, fmu: FMU2Slave, references: dict[str, list[int]], log: list[str]) -> None:
        self.fmu, self.references, self.log = fmu, references, log

    def set(self, **values: object) -> None:
        for name, value in values.items():
            self.fmu.setReal(self.references[name], np.ravel(value).tolist())

    def get(self, name: str) -> np.ndarray:
        return np.array(self.fmu.getReal(self.references[name]))

    def initialise(self, start_time: float = 0.0) -> None:
        self.fmu.setupExperiment(startTime=start_time)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()


@contextmanager
def loaded(path: Path) -> Iterator[tuple[fmpy.model_description.ModelDescription, str]]:
    """Description and folder of an extracted FMU."""
    folder = tempfile.mkdtemp()
    try:
        fmpy.extract(str(path), folder)
        yield fmpy.read_model_description(folder), folder
    finally:
        shutil.rmtree(folder)


def instantiate(description, folder: str, name: str = "one") -> Slave:  # type: ignore[no-untyped-def]
    """A new instance with logging on."""
    log: list[str] = []
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(lambda *a: log.append(a[4].decode()))
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
    callbacks.stepFinished = fmi2StepFinishedTYPE(0)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName=name,
                    modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate(loggingOn=True, callbacks=callbacks)
    references: dict[str, list[int]] = {}
    for variable in description.modelVariables:
        port = variable.name.partition("[")[0]
        references.setdefault(port, []).append(variable.valueReference)
    return Slave(fmu, references, log)
