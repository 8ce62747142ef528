"""Reports the contents of a GLB or VRM file as imported by Blender, as one line of JSON.

blender --background --factory-startup --python blender.py -- FILE
"""

import json
import sys

import bpy
import numpy

# The glTF importer of Debian's Blender 3.4 uses a name that Debian's NumPy 1.24 no longer has.
if "bool" not in numpy.__dict__:
    numpy.bool = bool

file = sys.argv[sys.argv.index("--") + 1]
bpy.ops.wm.read_factory_settings(use_empty=True)
# A VRM file is a glTF file with another extension.
bpy.ops.import_scene.gltf(filepath=file)

armatures = [item for item in bpy.data.objects if item.type == "ARMATURE"]
meshes = [item for item in bpy.data.objects if item.type == "MESH" and item.vertex_groups]
keys = {key.name for item in meshes if item.data.shape_keys for key in item.data.shape_keys.key_blocks}
lowest = min(
    (item.matrix_world @ vertex.co).z for item in meshes for vertex in item.data.vertices
)
print(
    "FOUND "
    + json.dumps(
        {
            "bones": sum(len(item.data.bones) for item in armatures),
            "triangles": sum(len(polygon.vertices) - 2 for item in meshes for polygon in item.data.polygons),
            "morphs": sorted(keys - {"Basis"}),
            "animations": sorted(action.name for action in bpy.data.actions),
            "materials": len({slot.material.name for item in meshes for slot in item.material_slots}),
            "images": len([image for image in bpy.data.images if image.size[0] > 0]),
            "lowest_m": lowest,
        }
    )
)
