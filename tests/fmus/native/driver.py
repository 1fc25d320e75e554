"""Drive a native FMU by port names, alike for FMI 2.0 and FMI 3.0."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import fmpy
import numpy as np
from fmpy.fmi2 import (
    FMU2Model,
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)
from fmpy.fmi3 import FMU3Model, FMU3Slave

from sightline.components import Component
from sightline.components.catalogue import blocks
from sightline.fmus.build import build
from sightline.fmus.model import Model, Variable, model_of
from sightline.fmus.python.runtime import Instance as PythonInstance
from sightline.fmus.python.runtime import Slot
from sightline.fmus.python.target import _slot
from sightline.fmus.tracing import trace

Fmi = Literal[2, 3]
FMU_CLASSES = {
    (2, "CoSimulation"): FMU2Slave, (2, "ModelExchange"): FMU2Model,
    (3, "CoSimulation"): FMU3Slave, (3, "ModelExchange"): FMU3Model,
}  # fmt: skip
ACCESS = {
    2: {"real": "Real", "integer": "Integer", "boolean": "Boolean", "enumeration": "Integer"},
    3: {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "enumeration": "Int64"},
}
PYTHON_TYPE = {"real": float, "integer": int, "boolean": bool, "enumeration": int}


def native_model(block: Component) -> Model:
    return model_of(block, trace(block), derivatives=True)


def _component(block: Component) -> str:
    """What the build knows a block by: those of the tests live in a file of theirs."""
    return block.name if block.name in blocks() else f"{inspect.getfile(type(block))}:{block.name}"


@dataclass
class Native:
    """An FMU, extracted."""

    model: Model
    fmi: Fmi
    path: Path
    folder: Path

    @classmethod
    def build(cls, block: Component, fmi: Fmi, root: Path) -> Native:
        model = native_model(block)
        path = build(_component(block), target="native", fmi=fmi)
        folder = root / f"{block.name}{fmi}"
        fmpy.extract(str(path), str(folder))
        return cls(model, fmi, path, folder)

    def instance(
        self, name: str = "one", interface: str = "CoSimulation", **options: Any
    ) -> Instance:
        return Instance(self, name, interface, options)

    def reference(self, name: str = "one") -> PythonInstance:
        """The same block behind the Python target's runtime."""
        slots = [Slot(**(_slot(v) | {"shape": v.shape})) for v in self.model.variables]
        return PythonInstance(self.model.block, slots, name)


class Instance:
    """One instance; ``log`` collects its messages. A call that fails raises FMICallException."""

    def __init__(self, native: Native, name: str, interface: str, options: dict[str, Any]) -> None:
        self.native, self.model, self.fmi, self.log = native, native.model, native.fmi, []
        description = fmpy.read_model_description(str(native.folder))
        self.fmu: Any = FMU_CLASSES[native.fmi, interface](
            guid=description.guid if native.fmi == 2 else description.instantiationToken,
            unzipDirectory=str(native.folder), instanceName=name,
            modelIdentifier=native.model.block.name,
        )  # fmt: skip
        logging = options.pop("logging", True)
        if native.fmi == 2:
            callbacks = fmi2CallbackFunctions()
            callbacks.logger = fmi2CallbackLoggerTYPE(
                lambda *a: self.log.append((a[3].decode(), a[4].decode().replace("%%", "%")))
            )
            callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
            callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
            callbacks.stepFinished = fmi2StepFinishedTYPE(0)
            self.fmu.instantiate(loggingOn=logging, callbacks=callbacks)
        else:
            self.fmu.instantiate(
                loggingOn=logging,
                logMessage=lambda _e, _s, c, m: self.log.append((c.decode(), m.decode())),
                **options,
            )

    @property
    def messages(self) -> str:
        return "\n".join(text for _, text in self.log)

    def _references(self, variable: Variable) -> list[int]:
        return list(variable.references) if self.fmi == 2 else [variable.reference]

    def set(self, **values: Any) -> None:
        for name, value in values.items():
            variable = self.model.by_name[name]
            flat = [PYTHON_TYPE[variable.type](x) for x in np.ravel(value)]
            setter = getattr(self.fmu, "set" + ACCESS[self.fmi][variable.type])
            setter(self._references(variable), flat)

    def get(self, name: str) -> np.ndarray:
        variable = self.model.by_name[name]
        getter = getattr(self.fmu, "get" + ACCESS[self.fmi][variable.type])
        size = () if self.fmi == 2 else (variable.size,)
        values = getter(self._references(variable), *size)
        return np.array(values, dtype=float).reshape(variable.shape)

    def all(self, *kinds: str) -> np.ndarray:
        """Values of all variables of these kinds, in order."""
        found = [np.ravel(self.get(v.name)) for v in self.model.of_kind(*kinds)]
        return np.concatenate([*found, np.zeros(0)])

    def enter(self, start: float = 0.0, stop: float | None = None) -> None:
        if self.fmi == 2:
            self.fmu.setupExperiment(startTime=start, stopTime=stop)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start, stopTime=stop)

    def initialise(self, start: float = 0.0, stop: float | None = None) -> None:
        self.enter(start, stop)
        self.fmu.exitInitializationMode()

    def step(self, time: float, h: float) -> tuple[bool, bool, float] | None:
        """FMI 3.0: event handling needed, early return, time reached."""
        result = self.fmu.doStep(time, h)
        if self.fmi == 2:
            return None
        event, _, early, reached = result
        return bool(event), bool(early), float(reached)

    def save(self) -> Any:
        return self.fmu.getFMUstate() if self.fmi == 2 else self.fmu.getFMUState()

    def restore(self, state: Any) -> None:
        (self.fmu.setFMUstate if self.fmi == 2 else self.fmu.setFMUState)(state)

    def free(self, state: Any) -> None:
        (self.fmu.freeFMUstate if self.fmi == 2 else self.fmu.freeFMUState)(state)

    def serialise(self, state: Any) -> bytes:
        f = self.fmu.serializeFMUstate if self.fmi == 2 else self.fmu.serializeFMUState
        return bytes(f(state))

    def deserialise(self, data: bytes) -> Any:
        f = self.fmu.deSerializeFMUstate if self.fmi == 2 else self.fmu.deserializeFMUState
        return f(data)

    def _flat(self, names: Sequence[str]) -> tuple[list[int], int]:
        variables = [self.model.by_name[n] for n in names]
        return [r for v in variables for r in self._references(v)], sum(v.size for v in variables)

    def forward(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Any) -> np.ndarray:
        u, size = self._flat(unknowns)
        k, _ = self._flat(knowns)
        f, size_ = self.fmu.getDirectionalDerivative, () if self.fmi == 2 else (size,)
        return np.array(f(u, k, list(seed), *size_))

    def reverse(self, unknowns: Sequence[str], knowns: Sequence[str], seed: Any) -> np.ndarray:
        u, _ = self._flat(unknowns)
        k, size = self._flat(knowns)
        return np.array(self.fmu.getAdjointDerivative(u, k, list(seed), size))
