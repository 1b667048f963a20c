"""The deformed body and the pressure on its contact face in PyVista: pip install pyvista."""

import contact3d
import pyvista as pv

run = contact3d.run("pipelines/newton.toml", "grid.h5", set={"body.brick.cells": [24, 8, 8]})

LARGER = 1000.0
body = run.to_pyvista().warp_by_vector("displacement", factor=LARGER)
face = run.to_pyvista("contact")
body["von Mises [MPa]"] = body["von_mises"] / 1e6
face["pressure [MPa]"] = face["pressure"] / 1e6

plotter = pv.Plotter(off_screen=True, window_size=(1280, 640))
plotter.set_background("white")
bar = {"color": "black", "vertical": True, "height": 0.6, "position_y": 0.2, "fmt": "%.0f"}
plotter.add_mesh(body, scalars="von Mises [MPa]", cmap="viridis", scalar_bar_args=bar | {"position_x": 0.88})
below = face.translate((0, 0, -0.8))
plotter.add_mesh(below, scalars="pressure [MPa]", cmap="YlOrRd", show_edges=True, scalar_bar_args=bar | {"position_x": 0.03})
plotter.camera_position = [(4.5, -6.0, 2.2), (1.5, 0.5, -0.1), (0, 0, 1)]
plotter.camera.zoom(1.3)
plotter.screenshot("grid.png")
print(f"{body.n_cells} tetrahedra, displacements {LARGER:.0f} times as large: grid.png")
