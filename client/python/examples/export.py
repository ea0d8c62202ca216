"""Writes a twin for Blender and for MuJoCo, and opens both files."""

import os
import subprocess

import mujoco
import trimesh

from bendtwin import Client

server = os.environ.get("BENDTWIN_SERVER", "http://127.0.0.1:7070")
with Client(server) as client:
    twin = next(client.twins())  # the newest

# The program comes with this package: the same command in a terminal does the same.
program = os.environ.get("BENDTWIN_BIN", "bendtwin")
for file in ("twin.glb", "twin.xml", "twin.html"):
    subprocess.run([program, "twin", "export", twin.name, file, "--server", server], check=True)

mesh = trimesh.load_scene("twin.glb").to_mesh()
print(f"twin.glb: {len(mesh.faces)} triangles, {mesh.extents.max():.2f} m long")
model = mujoco.MjModel.from_xml_path("twin.xml")
print(f"twin.xml: {model.nbody - 1} bodies, {model.neq} constraints")
print(f"twin.html: {os.path.getsize('twin.html') // 1000} kB, to be opened in any browser")
