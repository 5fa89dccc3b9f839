"""The unit of work of a fleet, for engines that run it on many machines.

    import arcsmith.fleet

    rows = arcsmith.fleet.diagnose_batch(table, unit="serial", mirror="mirror.toml")
    pyarrow.table(rows)   # a row for every unit, as in the table `units` of `arcsmith fleet`
"""

from ._arcsmith import Rows, diagnose_batch

__all__ = ["Rows", "diagnose_batch"]
