# Reports the contents of avatar.glb as imported by Godot 3, as one line of JSON.
extends SceneTree

var found = {"bones": 0, "triangles": 0, "morphs": [], "animations": [], "materials": 0}

func _init():
	var scene = load("res://avatar.glb")
	if scene == null:
		print("nothing was imported")
		quit(1)
		return
	look(scene.instance())
	found["morphs"].sort()
	found["animations"].sort()
	print("FOUND " + JSON.print(found))
	quit()

func look(node):
	if node is Skeleton:
		found["bones"] += node.get_bone_count()
	if node is AnimationPlayer:
		for name in node.get_animation_list():
			found["animations"].append(name)
	if node is MeshInstance:
		var mesh = node.mesh
		for shape in mesh.get_blend_shape_count():
			found["morphs"].append(mesh.get_blend_shape_name(shape))
		for surface in mesh.get_surface_count():
			found["triangles"] += mesh.surface_get_array_index_len(surface) / 3
			if mesh.surface_get_material(surface) != null:
				found["materials"] += 1
	for child in node.get_children():
		look(child)
