"""Calibration recordings of a mirror or an encoder in, proven firmware correction out.

`fit` fits the sensor's angular error, `apply` corrects readings, `generate` makes the correction for firmware with a proven
bound, `diagnose` names what a model leaves out, `simulate` runs a plant. They compute what the program `arcsmith` computes, to
the bit, and give it as objects that a notebook shows.

    import arcsmith

    fit = arcsmith.fit("calibration.csv", "mirror.toml")   # or a table, or a dict of columns
    print(fit)
    arcsmith.generate(fit, format="q31").write("firmware")
"""

from ._arcsmith import (
    ArcsmithError,
    Coefficients,
    Columns,
    Diagnosis,
    Fit,
    Generated,
    __version__,
    apply,
    diagnose,
    fit,
    generate,
    simulate,
)
from ._figures import Figures

__all__ = [
    "ArcsmithError",
    "Coefficients",
    "Columns",
    "Diagnosis",
    "Figures",
    "Fit",
    "Generated",
    "__version__",
    "apply",
    "diagnose",
    "fit",
    "generate",
    "simulate",
]
