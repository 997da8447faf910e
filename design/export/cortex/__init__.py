"""What an exported controller takes on a Cortex-M4F: flash, RAM, stack, instructions a step."""
