extends CharacterBody3D
## First person: W A S D walk, the mouse looks around, E opens and shuts the door, Escape frees the
## mouse.

const SPEED := 2.0  # m/s
const RADIANS_PER_PIXEL := 0.003
## Of the house, a shoulder's width inside the outer walls.
const LEAST := Vector3(0.3, 0, -5.3)
const MOST := Vector3(7.7, 0, 3.7)

@export var door: AulaBody3D


func _unhandled_input(event: InputEvent) -> void:
	if event is InputEventMouseButton and event.pressed:
		Input.mouse_mode = Input.MOUSE_MODE_CAPTURED
	elif event is InputEventMouseMotion and Input.mouse_mode == Input.MOUSE_MODE_CAPTURED:
		rotate_y(-event.relative.x * RADIANS_PER_PIXEL)
		var pitch: float = $Head.rotation.x - event.relative.y * RADIANS_PER_PIXEL
		$Head.rotation.x = clampf(pitch, -1.5, 1.5)
	elif event is InputEventKey and event.pressed and not event.echo:
		match event.physical_keycode:
			KEY_E:
				door.toggle()
			KEY_ESCAPE:
				Input.mouse_mode = Input.MOUSE_MODE_VISIBLE


func _physics_process(_delta: float) -> void:
	var direction := Vector3.ZERO
	for key: Array in [[KEY_W, Vector3.FORWARD], [KEY_S, Vector3.BACK], [KEY_A, Vector3.LEFT],
			[KEY_D, Vector3.RIGHT]]:
		if Input.is_physical_key_pressed(key[0]):
			direction += key[1]
	velocity = basis * direction.normalized() * SPEED
	move_and_slide()
	position = position.clamp(LEAST, MOST)
