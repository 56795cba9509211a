"""Studies of what a physical effect does to a contact: roughness; later creep, wear, coating, friction, plastic."""
