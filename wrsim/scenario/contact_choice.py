"""Contact models by short names: ``half-space``, ``kik-piotrowski+polach``, ``kik-piotrowski+strips=80``.

Parts are joined by ``+``: a normal model, a tangential model, and keys of [contact] with their values, or without one
(``strip_width_mm=``) to leave out a key of the scenario. What is not named stays as the scenario has it, but exact
pressures get exact creep forces unless a part sets others or the scenario is frictionless, and other pressures their
usual creep forces where the scenario names exact ones. ``file`` is the scenario's own choice.
"""

from typing import Any

from wrsim.contact.creep.laws import CREEP_LAWS
from wrsim.contact.settings import USUAL
from wrsim.errors import InputError
from wrsim.inputs.changes import key_path
from wrsim.inputs.toml_files import parse_value
from wrsim.inputs.values import meant
from wrsim.scenario.loading import Scenario
from wrsim.scenario.merging import holds_key

OWN = "file"
HERTZ = "hertz"
"""Hertz' ellipses on the contacts of another model, in comparisons."""


def with_contact_model(scenario: Scenario, name: str) -> Scenario:
    """The scenario with the contact model of that name, checked. Raises InputError that names the model."""
    values = _values(scenario, name)
    settings = {key: value for key, value in values.items() if value is not None}
    try:
        return scenario.with_values(settings, without=[*(values.keys() - settings)]) if values else scenario
    except InputError as error:
        raise InputError("\n".join(f'model "{name}": {line}' for line in str(error).split("\n"))) from None


def split_names(names: str) -> list[str]:
    """Names out of a list with commas. Raises InputError for an empty or a duplicate one."""
    models = [name.strip() for name in names.split(",")]
    for name in models:
        if not name:
            raise InputError(f'--contact {names}: has an empty name; write for example "kik-piotrowski,half-space"')
        if HERTZ in name.split("+") and name != HERTZ:
            raise InputError(f'--contact {names}: "{HERTZ}" stands alone: it has no creep forces and no keys')
        if models.count(name) > 1:
            raise InputError(f'--contact {names}: duplicate "{name}"')
    return models


def _values(scenario: Scenario, name: str) -> dict[str, Any]:
    chosen: dict[str, Any] = {}
    for part in (p.strip() for p in name.split("+")):
        if part == OWN:
            continue
        key, equals, text = (p.strip() for p in part.partition("="))
        if equals:
            if not text and not holds_key(scenario.merged.data, key_path(f"contact.{key}")):
                raise InputError(f'model "{name}": contact.{key} is not given in the scenario; KEY= unsets a key of it')
            chosen[f"contact.{key}"] = parse_value(text) if text else None
        elif part in USUAL and "contact.normal" not in chosen:
            chosen["contact.normal"] = part
        elif part in CREEP_LAWS and "contact.tangential" not in chosen:
            chosen["contact.tangential"] = part
        else:
            raise InputError(_unknown(name, part, chosen))
    section = scenario.spec.contact
    normal = chosen.get("contact.normal", section.normal)
    if "contact.tangential" not in chosen and "contact.normal" in chosen and section.tangential != "none":
        if normal == "half-space":
            chosen["contact.tangential"] = "half-space"
        elif section.tangential == "half-space" and normal in USUAL:
            chosen["contact.tangential"] = USUAL[normal].tangential
    return chosen


def _unknown(name: str, part: str, chosen: dict[str, Any]) -> str:
    where = f'model "{name}"' + (f': "{part}"' if part != name else "")
    for kind, known in (("normal", USUAL), ("tangential", CREEP_LAWS)):
        if part in known:
            return f'{where}: there is a {kind} model already ("{chosen[f"contact.{kind}"]}")'
    near = meant(part, [*dict.fromkeys((*USUAL, *CREEP_LAWS, OWN))])
    return (
        f"{where}: no contact model is called so; normal models are {', '.join(USUAL)}; "
        f"tangential ones {', '.join(CREEP_LAWS)}; "
        f'join them with "+", as in kik-piotrowski+polach or kik-piotrowski+strips=80{near}'
    )
