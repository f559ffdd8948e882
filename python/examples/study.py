"""A map over the workspace, as a table, a data set and a page."""

from kinetostat import Machine, workspace_map

FORCE = {"path_frame": {"radial_force_N": 215.0, "tangential_force_N": -10.0, "axial_force_N": -25.0}}

answer = workspace_map(
    Machine("orthoglide"), {"force": FORCE}, grid=5, phi_step_deg=30.0, figures=False, progress=False
)
print(answer)
table = answer.table("map").where(source="cutting")
print(table["deflection_mm"].max(), table.units["deflection_mm"])
data = table.to_xarray("x_mm", "y_mm", "z_mm")
print(data["deflection_mm"].sel(z_mm=0.0, method="nearest").values.round(3))
