"""Normal pressure after Kik and Piotrowski."""
