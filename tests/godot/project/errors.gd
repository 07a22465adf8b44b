extends Node
## Makes one mistake after the other; each is an error in the log.


func room_with(node: Node, ears := AulaListener3D.new()) -> AulaRoom:
	var room := AulaRoom.new()
	room.add_child(node)
	if ears:
		room.add_child(ears)
	return room


func attempt(title: String, root: Node, turn := Callable()) -> void:
	printerr("attempt: ", title)
	add_child(root)
	if turn:
		await turn.call(root)
	for i in 5:
		await get_tree().process_frame
	remove_child(root)
	root.free()


## Does something with a room that sounds, prints whether it still sounds, and removes its source.
func while_it_sounds(room: AulaRoom, turn: Callable) -> void:
	var near := AulaSource3D.new()
	near.stream = load("res://sounds/radio.wav")
	near.autoplay = true
	near.position = Vector3(0, 0, -900)
	room.add_child(near)
	var start := Time.get_ticks_msec()
	while room.response_length_s == 0 and Time.get_ticks_msec() < start + 60000:
		await get_tree().process_frame
	near.position = Vector3(0, 0, -1)
	await turn.call()
	if AudioServer.get_bus_peak_volume_left_db(0, 0) > -60:
		printerr("heard")
	near.stop()
	near.queue_free()


## Moves the first source out of reach, further with each frame, and a second one near.
func lose_source(room: AulaRoom) -> void:
	await while_it_sounds(room, func() -> void:
		for i in 60:
			room.get_child(0).position = Vector3(2e6 + 10 * i, 0, 0)
			await get_tree().create_timer(0.01).timeout)


## A new room cannot be made, since its responses are too long.
func fail_to_rebuild(room: AulaRoom) -> void:
	await while_it_sounds(room, func() -> void:
		room.ir_length_s = 20
		room.rebuild()
		await get_tree().create_timer(1.0).timeout)


func box(material: AulaMaterial) -> AulaBody3D:
	var body := AulaBody3D.new()
	body.material = material
	var mesh := MeshInstance3D.new()
	mesh.mesh = BoxMesh.new()
	body.add_child(mesh)
	return body


func _ready() -> void:
	await attempt("no room", AulaSource3D.new())
	await attempt("no room for ears", AulaListener3D.new())
	await attempt("no listener", room_with(AulaSource3D.new(), null))
	var unknown := AulaMaterial.new()
	unknown.preset = "cheese"
	await attempt("unknown preset", room_with(box(unknown)))
	var short := AulaMaterial.new()
	short.preset = ""
	short.absorption = PackedFloat32Array([0.1, 0.2])
	await attempt("two octaves", room_with(box(short)))
	var negative := AulaMaterial.new()
	negative.preset = ""
	negative.absorption = PackedFloat32Array([-1, 0, 0, 0, 0, 0, 0, 0])
	await attempt("negative absorption", room_with(box(negative)))
	var loud := AulaSource3D.new()
	loud.gain_db = 1000
	await attempt("loud source", room_with(loud))
	var aimless := AulaSource3D.new()
	aimless.directivity = "banana"
	await attempt("unknown directivity", room_with(aimless))
	var far := AulaListener3D.new()
	far.position = Vector3(NAN, 0, 0)
	await attempt("listener nowhere", room_with(Node.new(), far))
	var nameless := room_with(Node.new())
	nameless.ready.connect(func() -> void: nameless.save_scene("/nowhere/at/all.json"))
	await attempt("a file that cannot be written", nameless)
	# A room without bounds, in which a source runs away: an error in each frame.
	await attempt("no listener and a lost source", room_with(AulaSource3D.new(), null), lose_source)
	await attempt("a source beside a lost one", room_with(AulaSource3D.new()), lose_source)
	await attempt("a rebuild that fails", room_with(Node.new()), fail_to_rebuild)
	await attempt("a room that comes again", room_with(box(unknown)), func(room: Node) -> void:
		for i in 5:
			await get_tree().process_frame
		remove_child(room)
		add_child(room))
	printerr("attempt: end")
	get_tree().quit()
