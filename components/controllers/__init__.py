"""Controllers: from measurements to force and torque."""
