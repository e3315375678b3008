"""What the study friction_speed.toml asks of every result besides its channels."""


def numbers(result):
    """Work of the creep forces over the whole way, both wheels [kJ]."""
    data = result.dataset
    power = data["T_gamma"].sum("wheel").isel(wheelset=0)
    return {"wear_work_kJ": float(power.integrate("time") * data["speed"].mean()) / 1e3}
