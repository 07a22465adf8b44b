extends AulaBody3D
## A door that opens and shuts within a second. The node is at the hinge.

const OPEN_ANGLE := 1.6

var is_open := false


func toggle() -> void:
	is_open = not is_open
	create_tween().tween_property(self, "rotation:y", OPEN_ANGLE if is_open else 0.0, 1.0)
