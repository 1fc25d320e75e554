"""A controller of one's own as a pythonfmu script, without Sightline: pythonfmu build -f this.

Law A of the line-of-sight paper. An output is computed when it is read, from the inputs of that
moment, so that the controller adds no delay.
"""

import numpy as np
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

INPUTS = {"line_of_sight": 3, "target_line_of_sight": 3, "relative_velocity": 3,
          "angular_velocity": 3}
PARAMETERS = {"mass": 1.0, "rate_gain": 0.25, "velocity_gain": 0.025, "alignment_gain": 0.05,
              "range_gain": 0.001, "desired_range": 20.0}


class PythonScript(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.range = 1.0
        self.register_variable(Real("range", causality=Fmi2Causality.input))
        for name, value in PARAMETERS.items():
            setattr(self, name, value)
            self.register_variable(Real(name, causality=Fmi2Causality.parameter,
                                        variability=Fmi2Variability.tunable))
        for name, size in INPUTS.items():
            setattr(self, name, np.zeros(size))
            self.register_elements(name, size, Fmi2Causality.input)
        for name in ("torque", "force"):
            self.register_elements(name, 3, Fmi2Causality.output)

    def register_elements(self, name, size, causality):
        for i in range(size):
            self.register_variable(Real(
                f"{name}[{i + 1}]", causality=causality,
                getter=lambda i=i: float(getattr(self, name)[i]),
                setter=lambda value, i=i: getattr(self, name).__setitem__(i, value),
            ))

    @property
    def torque(self):
        turn = np.cross(self.target_line_of_sight, self.line_of_sight)
        return -self.rate_gain * self.angular_velocity - self.alignment_gain * turn

    @property
    def force(self):
        b12, b21 = self.line_of_sight, self.target_line_of_sight
        pull = self.range_gain * (self.range - self.desired_range) * b12
        swing = self.alignment_gain / self.range * (b21 - (b12 @ b21) * b12)
        return self.mass * (self.velocity_gain * self.relative_velocity + pull + swing)

    def do_step(self, current_time, step_size):
        return True
